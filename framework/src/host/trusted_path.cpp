#include "host/trusted_path.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <grp.h>
#include <pwd.h>
#include <string_view>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/xattr.h>

namespace deform {
namespace {

namespace fs = std::filesystem;

/// As many links one after another as the kernel follows.
constexpr int kMostLinks = 40;
/// Of a group or user in the system's tables.
constexpr std::size_t kEntry = std::size_t{1} << 14U;

bool is_trusted(uid_t owner) { return owner == 0 || owner == ::geteuid(); }

/// Whose own group it is need not be told among its members.
bool is_primary_of_another(gid_t group, uid_t owner) {
  bool found = false;
  ::setpwent();
  // NOLINTNEXTLINE(concurrency-mt-unsafe): plugins are looked for before there are other threads
  for (const passwd* user = ::getpwent(); user != nullptr && !found; user = ::getpwent())
    found = user->pw_gid == group && user->pw_uid != owner;
  ::endpwent();
  return found;
}

/// Whether more than owner, group and all others are told what they may do: the group's bits are
/// then what the others who are named may do at most.
bool has_access_list(const fs::path& path) {
  return ::lgetxattr(path.c_str(), "system.posix_acl_access", nullptr, 0) > 0;
}

/// Whether a group is that of its owner alone: the custom where new files are writable by groups.
bool is_private(gid_t group, uid_t owner) {
  std::array<char, kEntry> room{};
  passwd user{};
  passwd* found_user = nullptr;
  if (::getpwuid_r(owner, &user, room.data(), room.size(), &found_user) != 0) return false;
  if (found_user == nullptr || user.pw_gid != group) return false;
  std::array<char, kEntry> more_room{};
  ::group members{};
  ::group* found_group = nullptr;
  if (::getgrgid_r(group, &members, more_room.data(), more_room.size(), &found_group) != 0 ||
      found_group == nullptr)
    return false;
  for (char** member = members.gr_mem; *member != nullptr; ++member)
    if (std::string_view(*member) != user.pw_name) return false;
  return !is_primary_of_another(group, owner);
}

/// Who else could change what is there; empty: nobody.
std::string others_of(const fs::path& path, const struct stat& status, bool leads_on) {
  if (!is_trusted(status.st_uid)) return fmt::format("belongs to another user ({})", status.st_uid);
  if (leads_on && (status.st_mode & S_ISVTX) != 0) return "";
  if ((status.st_mode & S_IWOTH) != 0) return "is world-writable";
  if ((status.st_mode & S_IWGRP) != 0 && !is_private(status.st_gid, status.st_uid))
    return fmt::format("is writable by a group ({})", status.st_gid);
  if ((status.st_mode & S_IWGRP) != 0 && has_access_list(path))
    return "may be writable by others: it has an access control list";
  return "";
}

void put_first(const fs::path& path, std::deque<std::string>& steps) {
  std::deque<std::string> first;
  for (const fs::path& step : path.relative_path())
    if (!step.empty() && step != ".") first.push_back(step.string());
  steps.insert(steps.begin(), first.begin(), first.end());
}

/// `why`, which is about a place on the way.
std::string on_the_way(const fs::path& place, const std::string& why) {
  return fmt::format("is not safe: {} {}", place.string(), why);
}

}  // namespace

std::string objection_to(const fs::path& path) {
  std::deque<std::string> steps;  // that are left
  put_first(path, steps);
  fs::path here = "/";
  int links = 0;
  for (;;) {
    const bool is_path = steps.empty() && links == 0;
    struct stat status {};
    if (::lstat(here.c_str(), &status) != 0)
      return errno == ENOENT ? "does not exist" : std::generic_category().message(errno);
    if (S_ISLNK(status.st_mode)) {
      // Nobody writes to a link, but whose it is may put another in its place.
      if (!is_trusted(status.st_uid)) {
        const std::string why = fmt::format("is a link of another user ({})", status.st_uid);
        return is_path ? why : on_the_way(here, why);
      }
      std::error_code error;
      const fs::path target = fs::read_symlink(here, error);
      if (error || ++links > kMostLinks) return "cannot be followed";
      here = target.is_absolute() ? fs::path("/") : here.parent_path();
      put_first(target, steps);
      continue;
    }
    const std::string why = others_of(here, status, !steps.empty());
    if (!why.empty()) return is_path ? why : on_the_way(here, why);
    if (steps.empty()) return "";
    const std::string step = steps.front();
    steps.pop_front();
    here = step == ".." ? here.parent_path() : here / step;
  }
}

}  // namespace deform
