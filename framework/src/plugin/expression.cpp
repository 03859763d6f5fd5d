#include "deform/plugin/expression.h"

#include <algorithm>
#include <cctype>
#include <muParser.h>
#include <mutex>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "json/shown.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The name with which a token begins.
std::string word_of(const std::string& token) {
  return token.substr(
      0, static_cast<std::size_t>(std::ranges::find_if_not(token, is_word) - token.begin()));
}

std::vector<std::string> names_in(const std::vector<std::string>& variables,
                                  const mu::Parser& parser) {
  std::vector<std::string> names = variables;
  for (const auto& constant : parser.GetConst())
    if (constant.first.front() != '_') names.push_back(constant.first);  // _pi and _e: pi, exp(1)
  for (const auto& function : parser.GetFunDef()) names.push_back(function.first);
  return names;
}

/// Whether a formula calls something else so: what names_in would list, without making the list.
bool is_taken(const std::string& name, const std::vector<std::string>& variables,
              const mu::Parser& parser) {
  const bool is_constant = !name.starts_with('_') && parser.GetConst().contains(name);
  return is_constant || std::ranges::find(variables, name) != variables.end() ||
         parser.GetFunDef().contains(name);
}

/// muParser's own sentences end in a full stop, sometimes; ours do not.
std::string sentence(std::string text) {
  while (!text.empty() && text.back() == '.') text.pop_back();
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

/// A single = assigns, which a formula must not.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const char before = i > 0 ? text[i - 1] : ' ', after = i + 1 < text.size() ? text[i + 1] : ' ';
    const bool compares = before == '<' || before == '>' || before == '!' || before == '=';
    if (!compares && after != '=') return true;
  }
  return false;
}

}  // namespace

ExpressionError::ExpressionError(const std::string& message, std::string why, std::string token)
    : InputError(message), why_(std::move(why)), token_(std::move(token)) {}
ExpressionError::~ExpressionError() = default;

/// A parser, the places that its variables point to, and what keeps two threads from both.
struct Expression::Parsed {
  std::string text;
  std::vector<std::string> variables;
  std::vector<double> values;
  mu::Parser parser;
  std::mutex mutex;

  [[noreturn]] void reject(const std::string& why, const std::string& token) const {
    std::string of;
    for (const std::string& name : variables) of += (of.empty() ? " of " : ", ") + name;
    throw ExpressionError(
        fmt::format("found {}, expected a formula{}: {}", shown(Json(text)), of, why), why, token);
  }

  [[noreturn]] static void reject_constant(const std::string& why, const std::string& name) {
    throw ExpressionError(why, why, name);  // whatever the formula is
  }

  void define(const Constants& constants) {
    values.resize(variables.size(), 1.0);
    for (std::size_t i = 0; i < values.size(); ++i) parser.DefineVar(variables[i], &values[i]);
    parser.DefineConst("pi", std::numbers::pi);
    for (const auto& [name, value] : constants) {
      if (is_taken(name, variables, parser))
        reject_constant(fmt::format("the constant \"{}\" has the name of something else", name),
                        name);
      try {
        parser.DefineConst(name, value);
      } catch (const mu::ParserError&) {
        reject_constant(fmt::format("a constant cannot be called {}", shown(Json(name))), name);
      }
    }
  }

  void parse() {
    if (assigns(text)) reject("a formula cannot assign: equal is ==", "=");
    try {
      parser.SetExpr(text);
      (void)parser.Eval();
    } catch (const mu::ParserError& error) {
      const std::string token = error.GetToken(), word = word_of(token);
      if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN && !word.empty())
        reject(fmt::format("there is no \"{}\"{}", word,
                           did_you_mean(word, names_in(variables, parser))),
               token);
      reject(sentence(error.GetMsg()), token);
    }
    if (parser.GetNumResults() != 1)
      reject(fmt::format("these are {} formulas", parser.GetNumResults()), ",");
  }
};

Expression::Expression(std::string text, std::vector<std::string> variables,
                       const Constants& constants)
    : parsed_(std::make_shared<Parsed>()) {
  parsed_->text = std::move(text);
  parsed_->variables = std::move(variables);
  parsed_->define(constants);
  parsed_->parse();
}

const std::string& Expression::text() const { return parsed_->text; }

double Expression::operator()(std::span<const double> values) const {
  Parsed& parsed = *parsed_;
  if (values.size() != parsed.variables.size())
    throw Error(ExitCode::internal_error,
                fmt::format("a formula of {} variables was given {} values",
                            parsed.variables.size(), values.size()));
  const std::lock_guard lock(parsed.mutex);
  std::ranges::copy(values, parsed.values.begin());
  try {
    return parsed.parser.Eval();
  } catch (const mu::ParserError& error) {
    parsed.reject(sentence(error.GetMsg()), error.GetToken());
  }
}

}  // namespace deform
