#include "deform/error.h"

#include <utility>

namespace deform {
namespace {

/// One line a problem. Messages name their place themselves, so nothing is added here.
std::string lines(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) text += (text.empty() ? "" : "\n") + problem.message;
  return text;
}

std::string divergence(const std::string& reason, long step, long node, const std::string& term) {
  std::string text = reason + " (step " + std::to_string(step);
  if (node >= 0) text += ", node " + std::to_string(node);
  if (!term.empty()) text += ", " + term;
  return text + ")";
}

}  // namespace

Error::Error(ExitCode code, const std::string& message)
    : std::runtime_error(message), code_(code) {}
Error::~Error() = default;

InputError::InputError(std::vector<Problem> problems)
    : Error(ExitCode::bad_input, lines(problems)), problems_(std::move(problems)) {}
InputError::InputError(const std::string& message) : InputError({Problem{"", message}}) {}
InputError::~InputError() = default;

Diverged::Diverged(const std::string& reason, long step, long node, std::string term)
    : Error(ExitCode::diverged, divergence(reason, step, node, term)),
      step_(step),
      node_(node),
      term_(std::move(term)) {}
Diverged::~Diverged() = default;

StepTooLong::StepTooLong(const std::string& reason, double longest)
    : Error(ExitCode::diverged, reason), longest_(longest) {}
StepTooLong::~StepTooLong() = default;

PluginFailure::PluginFailure(const std::string& message)
    : Error(ExitCode::plugin_failed, message) {}
PluginFailure::~PluginFailure() = default;

}  // namespace deform
