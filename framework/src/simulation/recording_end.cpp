/// How a run ends: done, given up, or by an error; what is left in its directory.
#include <future>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "files/files.h"
#include "files/sha256.h"
#include "simulation/recording.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

constexpr const char* kSummaryFile = "summary.json";
/// What a profiled run leaves in its directory.
constexpr const char *kProfileTable = "profile.txt", *kProfileTrace = "trace.json";
/// Of who gives up, for what others are about.
constexpr std::chrono::milliseconds kLongestWait{100};

}  // namespace

/// Where the new run ended before its first step, and there is an old one.
void Recording::keep_old_run(RunResult& result) {
  if (!held_.give_old_back()) return;
  result.kept_old_run = true;
  result.reason += fmt::format("; the run that was in '{}' stays", options_.folder.string());
}

void Recording::give_up() noexcept {
  if (!options_.abandon) return;
  RunResult result;
  result.code = ExitCode::interrupted;
  // Not let go any more: what the main thread is writing gets into the folder now or never.
  const std::unique_lock no_more(checkpointing_, kLongestWait);
  try {
    is_given_up_ = true;
    result = stock_.result;
    result.stepping_seconds = stepping_seconds();
    end_within(result);
    conclude(result, leave_files(result));
    if (stock_.has_old_run) and_also(result, [&] { keep_old_run(result); });
  } catch (...) {  // no room for a word of it, and the process has to end all the same
  }
  options_.abandon(result);
}

void Recording::end_within(RunResult& result) {
  const bool is_first = result.code == ExitCode::done;
  is_thrown_away_ = true;
  if (stock_.fallback != nullptr) and_also(result, [this] { write(*stock_.fallback); });
  if (!is_first) return;  // the first reason is the one that counts
  const long done = stock_.steps, total = scene_.steps(), kept = checkpoint_step_;
  const std::string where =
      stock_.doing == Doing::stepping
          ? fmt::format("within step {} of {}, which is thrown away", done + 1, total)
          : fmt::format("after {} of {} steps, before all was recorded", done, total);
  end(result, ExitCode::interrupted,
      fmt::format("interrupted {}; {}", where,
                  kept >= 0 ? fmt::format("--resume goes on after step {}", kept)
                            : "there is no checkpoint yet"));
}

void Recording::end(RunResult& result, ExitCode code, const std::string& reason) {
  result.code = code;
  result.reason = reason;
  log::info(fmt::format("the run ends: {}", reason));
}

void Recording::end_with(const Error& error) {
  const bool names_step = error.code() == ExitCode::diverged;
  end_with(error.code(), names_step ? error.what()
                                    : fmt::format("{} (after step {})", error.what(),
                                                  parts_.simulation->steps()));
}

void Recording::finish() {
  std::vector<WrittenFile> files;
  watched(Doing::ending, [&] {
    if (divergence_ && divergence_->step() > parts_.simulation->steps())
      and_also([this] { record(true, true); });  // the last good state
    result_.stepping_seconds = stepping_seconds();
    and_also([this] { writing_.drain(); });
    and_also([this] { parts_.outputs->end(); });
    if (profile_) and_also([this] { write_profile(); });
    files = close_files(result_);
  });
  take_stock(Doing::ending);
  conclude(result_, files);
}

std::vector<WrittenFile> Recording::leave_files(RunResult& result) {
  const bool is_written = writing_.drain_within(kLongestWait);
  // The main thread is at work with them otherwise.
  if (stock_.doing != Doing::stepping) return {};
  if (is_written) {
    // What hangs is left behind, with the process.
    auto ending = std::make_shared<std::promise<void>>();
    std::future<void> ended = ending->get_future();
    std::thread([this, ending] {
      try {
        parts_.outputs->end();
        ending->set_value();
      } catch (...) {
        ending->set_exception(std::current_exception());
      }
    }).detach();
    if (ended.wait_for(kLongestWait) == std::future_status::ready)
      and_also(result, [&] { ended.get(); });
  }
  return close_files(result);
}

void Recording::conclude(RunResult& result, const std::vector<WrittenFile>& files) {
  for (const WrittenFile& file : files) manifest_.add_result(file);
  result.steps = stock_.steps;
  result.times = stock_.times;
  result.times.steps = stock_.steps - result.resumed_after;
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result.figures.emplace_back(header_of(columns[i]), stock_.figures[i].last);
  }
  and_also(result, [&] {
    const std::string text =
        summary(result).dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
    write_atomically(folder_ / kSummaryFile, text);
    manifest_.add_result({kSummaryFile, text.size(), sha256_of(text)});
  });
  result.wall_seconds = seconds();
  log::info(fmt::format("{} after {} steps and {:.3f} s", status_of(result.code), result.steps,
                        result.wall_seconds));
  last_note_.reset();
  if (!is_given_up_) and_also(result, [this] { log_->close(); });
  manifest_.finish(result, stock_.solver);
  and_also(result, [this] { manifest_.write(folder_); });
}

std::vector<WrittenFile> Recording::close_files(RunResult& result) {
  std::vector<WrittenFile> files;
  and_also(result, [&] {
    if (const auto table = parts_.probes->close()) files.push_back(*table);
  });
  and_also(result, [&] {
    if (trajectory_) files.push_back(trajectory_->close());
  });
  return files;
}

void Recording::write_profile() {
  result_.profile = profile_->table();
  write_atomically(folder_ / kProfileTable, result_.profile);
  write_atomically(folder_ / kProfileTrace, profile_->trace());
}

Json Recording::summary(const RunResult& result) const {
  Json json;
  json["status"] = status_of(result.code);
  json["exit_code"] = static_cast<int>(result.code);
  json["reason"] = result.reason;
  json["steps"] = result.steps;
  json["time"] = stock_.time;
  if (divergence_) {
    json["step"] = divergence_->step();
    json["node"] = divergence_->node() >= 0 ? Json(divergence_->node()) : Json(nullptr);
    json["term"] = divergence_->term();
  }
  json["probes"] = Json::object();
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnSummary& column = stock_.figures[i];
    // NaN, where there is no figure, is written as null.
    json["probes"][columns[i].name] = {{"unit", columns[i].unit},
                                       {"final", column.last},
                                       {"min", column.minimum},
                                       {"max", column.maximum}};
  }
  return json;
}

}  // namespace deform
