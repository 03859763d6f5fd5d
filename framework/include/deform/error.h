/// The errors that cross the boundary between framework, plugins and programs.
///
/// Only these and std:: exceptions may leave a plugin; anything else is reported as a plugin
/// failure.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

/// What a program ends with (design: command line contract).
enum class ExitCode : int {
  done = 0,
  internal_error = 1,
  bad_input = 2,
  diverged = 3,
  plugin_failed = 4,
  expectation_failed = 5,
  interrupted = 130,
};

/// Base of all errors that the framework raises.
class DEFORM_API Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message);
  ~Error() override;
  [[nodiscard]] ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// One thing that is wrong with an input: where, and the rule that it breaks (value included).
struct Problem {
  std::string pointer;  ///< JSON pointer of the value, "" for the whole
  std::string message;  ///< the value, the rule, the nearest valid name
};

/// Bad input: carries every problem that was found, so that all can be reported at once.
class DEFORM_API InputError : public Error {
 public:
  explicit InputError(std::vector<Problem> problems);
  /// A problem with the plugin's own object; the framework adds the pointer.
  explicit InputError(const std::string& message);
  ~InputError() override;
  [[nodiscard]] const std::vector<Problem>& problems() const noexcept { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// The state is not finite or has left all bounds; what() names step, node and term.
class DEFORM_API Diverged : public Error {
 public:
  Diverged(const std::string& reason, long step, long node, std::string term);
  ~Diverged() override;

  [[nodiscard]] long step() const noexcept { return step_; }
  [[nodiscard]] long node() const noexcept { return node_; }
  [[nodiscard]] const std::string& term() const noexcept { return term_; }

 private:
  long step_;
  long node_;
  std::string term_;
};

/// A plugin asks for a shorter step than the one that is being taken: thrown by an energy, force,
/// constraint or collider while it is evaluated. Integrators that choose their steps try again;
/// under the others the run ends as diverged.
class DEFORM_API StepTooLong : public Error {
 public:
  /// `longest`: the step to try instead [s]; 0: half of this one.
  explicit StepTooLong(const std::string& reason, double longest = 0);
  ~StepTooLong() override;
  [[nodiscard]] double longest() const noexcept { return longest_; }

 private:
  double longest_;
};

/// A plugin threw, or broke its contract, while running; what() names plugin, file and cause.
class DEFORM_API PluginFailure : public Error {
 public:
  explicit PluginFailure(const std::string& message);
  ~PluginFailure() override;
};

}  // namespace deform
