#include "compare/expectation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/plugin/expression.h"

#include "json/json_document.h"
#include "json/json_pointer.h"
#include "scene/scene_problems.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

/// A claim with the figures that it names replaced by variables, which have simpler names.
struct Formula {
  std::string text;
  std::vector<std::pair<std::string, std::string>> figures;  // of each variable: run, figure
};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

std::string variable(std::size_t i) { return "figure" + std::to_string(i); }

/// The run whose name and a dot stand at the beginning; of several the longest: names may hold dots
/// and signs.
std::string run_at(std::string_view text, const std::vector<std::string>& runs) {
  std::string longest;
  for (const std::string& run : runs) {
    if (text.starts_with(run + ".") && run.size() > longest.size()) longest = run;
  }
  return longest;
}

Formula formula_of(const std::string& claim, const std::vector<std::string>& runs) {
  Formula formula;
  for (std::size_t i = 0; i < claim.size();) {
    const bool starts = i == 0 || !(is_word(claim[i - 1]) || claim[i - 1] == '.');
    const std::string run = starts ? run_at(std::string_view(claim).substr(i), runs) : "";
    if (run.empty()) {
      formula.text += claim[i++];
      continue;
    }
    std::size_t end = i += run.size() + 1;
    while (end < claim.size() && (is_word(claim[end]) || claim[end] == '.')) ++end;
    formula.text += variable(formula.figures.size());
    formula.figures.emplace_back(run, claim.substr(i, end - i));
    i = end;
  }
  return formula;
}

/// The formula as a function of its figures. Throws ExpressionError.
Expression parse(const Formula& formula) {
  std::vector<std::string> variables;
  for (std::size_t i = 0; i < formula.figures.size(); ++i) variables.push_back(variable(i));
  return {formula.text, variables};
}

std::vector<std::string> names_of(const ComparisonPlan& plan) {
  std::vector<std::string> names;
  for (const PlannedRun& run : plan.runs) names.push_back(run.name);
  return names;
}

/// Whether a figure is of the difference from the reference.
bool is_of_difference(std::string_view figure) {
  constexpr std::array<std::string_view, 4> kDistances{"distance", "rms", "hausdorff", "parts_at"};
  return figure.starts_with("difference.") ||
         std::ranges::any_of(kDistances, [&](std::string_view distance) {
           return figure == distance || figure == std::string(distance) + ".max";
         });
}

/// The figures that a run will have: those of figures_of.
std::vector<std::string> figures_to_be(const PlannedRun& run, const ComparisonPlan& plan) {
  std::vector<std::string> figures{"steps", "time", "done"};
  for (const std::string& column : run.columns)
    for (const char* const of : {"", ".min", ".max"}) figures.push_back(column + of);
  if (run.name == plan.reference) return figures;
  for (const char* const distance : {"distance", "rms", "hausdorff"})
    for (const char* const of : {"", ".max"}) figures.push_back(std::string(distance) + of);
  figures.emplace_back("parts_at");
  for (const std::string& column : run.columns)
    for (const char* const of : {"", ".max"}) figures.push_back("difference." + column + of);
  return figures;
}

/// Why a formula's figures cannot be looked at; nothing where they can, as far as is known.
std::optional<std::string> objection(const Formula& formula, const ComparisonPlan& plan) {
  for (const auto& [name, figure] : formula.figures) {
    const PlannedRun& run = *std::ranges::find(plan.runs, name, &PlannedRun::name);
    if (!run.refused.empty()) continue;  // a row with its reason, whose probes nobody knows
    const std::vector<std::string> known = figures_to_be(run, plan);
    if (std::ranges::find(known, figure) != known.end()) continue;
    if (name == plan.reference && is_of_difference(figure))
      return fmt::format("\"{}\" is the reference, which has no {}", name, figure);
    return fmt::format("\"{}\" has no figure \"{}\"{}", name, figure, did_you_mean(figure, known));
  }
  return std::nullopt;
}

/// Why a claim is none; nothing if it is one.
std::optional<std::string> objection(const std::string& claim, const ComparisonPlan& plan) {
  const std::vector<std::string> runs = names_of(plan);
  const Formula formula = formula_of(claim, runs);
  try {
    (void)parse(formula);
  } catch (const ExpressionError& e) {
    std::string why = e.why();
    const std::string word = e.token().substr(0, e.token().find('.'));
    if (!word.empty() && is_word(word.front())) {
      why = fmt::format("\"{}\" is no run{}", word, did_you_mean(word, runs));
    }
    return fmt::format("found \"{}\", expected a formula over RUN.FIGURE: {}", claim, why);
  }
  const bool compares = claim.find_first_of("<>") != std::string::npos ||
                        claim.find("==") != std::string::npos ||
                        claim.find("!=") != std::string::npos;
  if (!compares || formula.figures.empty())
    return fmt::format(
        "found \"{}\", expected a comparison (<, <=, >, >=, ==, !=) of at least one "
        "RUN.FIGURE",
        claim);
  if (const auto why = objection(formula, plan))
    return fmt::format("found \"{}\", but {}", claim, *why);
  return std::nullopt;
}

std::string number_text(double value) { return fmt::format("{:.6g}", value); }

}  // namespace

std::vector<std::string> read_claims(const std::filesystem::path& file,
                                     const ComparisonPlan& plan) {
  const JsonDocument document = JsonDocument::read(file);
  SceneProblems problems(document);
  std::vector<Problem> found;
  for (const JsonProblem& problem : document.problems())
    found.push_back(to_problem(to_scene_problem(problem, document.name())));
  if (!found.empty()) throw InputError(std::move(found));

  std::vector<std::string> claims;
  const Json& root = document.root();
  const bool right = root.is_object() && root.size() == 1 && root.contains("claims") &&
                     root["claims"].is_array() && !root["claims"].empty();
  if (!right)
    problems.add("", R"(expected {"claims": ["RUN.FIGURE < RUN.FIGURE", …]} and nothing else)");
  for (std::size_t i = 0; right && i < root["claims"].size(); ++i) {
    const Json& claim = root["claims"][i];
    const std::string pointer = child_pointer("/claims", i);
    if (!claim.is_string()) {
      problems.add(pointer, "found " + claim.dump() + ", expected text");
      continue;
    }
    claims.push_back(claim.get<std::string>());
    if (const auto why = objection(claims.back(), plan)) problems.add(pointer, *why);
  }
  for (const SceneProblem& problem : problems.sorted()) found.push_back(to_problem(problem));
  if (!found.empty()) throw InputError(std::move(found));
  return claims;
}

std::vector<Claim> check_claims(const std::vector<std::string>& claims,
                                const Comparison& comparison) {
  const std::vector<RunComparison>& runs = comparison.runs;
  const bool stands_in = comparison.reference != comparison.planned_reference;
  std::vector<std::string> names;
  for (const RunComparison& run : runs) names.push_back(run.name);
  std::vector<Claim> checked;
  for (const std::string& text : claims) {
    const Formula formula = formula_of(text, names);
    std::vector<double> values;
    Claim claim{text, true, ""};
    for (const auto& [name, figure] : formula.figures) {
      const auto run = std::ranges::find(runs, name, &RunComparison::name);
      values.push_back(run->figure(figure));
      const std::string separator = claim.explanation.empty() ? "" : ", ";
      if (stands_in && is_of_difference(figure)) {
        claim.holds = false;
        claim.explanation += fmt::format("{}{}.{} is not of {}, the reference", separator, name,
                                         figure, comparison.planned_reference);
      } else if (std::isnan(values.back())) {
        std::vector<std::string> known;
        for (const Figure& f : run->figures) known.push_back(f.name);
        claim.holds = false;
        claim.explanation += fmt::format("{}{}.{} is missing{}", separator, name, figure,
                                         did_you_mean(figure, known));
      } else {
        claim.explanation +=
            fmt::format("{}{}.{} = {}", separator, name, figure, number_text(values.back()));
      }
    }
    claim.holds = claim.holds && parse(formula)(values) != 0;
    checked.push_back(std::move(claim));
  }
  return checked;
}

}  // namespace deform
