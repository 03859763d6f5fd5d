#include "simulation/held_folder.h"

#include <system_error>
#include <utility>

#include "simulation/old_run.h"
#include "simulation/run_directory.h"

namespace deform {

namespace fs = std::filesystem;
namespace {

/// Nothing, not even a lock, is written into a folder of somebody else.
bool is_ours(const fs::path& folder) {
  return holds_nothing(folder) || has_manifest(folder) || has_old_run(folder);
}

}  // namespace

HeldFolder::HeldFolder(const fs::path& folder, FolderUse use)
    : folder_(fs::absolute(folder)), use_(use) {
  require_unheld(folder);
  // By the name that the user gave.
  if (use != FolderUse::resumed) check_run_directory(folder, use == FolderUse::replaced);
  std::error_code error;
  if (!fs::is_directory(folder_, error) || !is_ours(folder_)) return;
  lock_.emplace(folder_);
  give_old_run_back(folder_);
}

void HeldFolder::take() {
  if (lock_) return;
  make_run_directory(folder_);
  lock_.emplace(folder_);
  give_old_run_back(folder_);
  if (!holds_nothing(folder_)) check_run_directory(folder_, use_ != FolderUse::made);
}

void HeldFolder::begin_anew(bool is_worth_keeping) {
  take();
  if (is_worth_keeping && !holds_nothing(folder_)) {
    has_old_ = true;
    set_old_run_aside(folder_);
  } else {
    empty_run_directory(folder_);
  }
}

void HeldFolder::drop_old() {
  if (std::exchange(has_old_, false)) drop_old_run(folder_);
}

bool HeldFolder::give_old_back() {
  if (!std::exchange(has_old_, false)) return false;
  give_old_run_back(folder_);
  return true;
}

}  // namespace deform
