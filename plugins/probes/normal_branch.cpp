/// Which cases of its rule a normal estimator is in, by area.
#include <algorithm>
#include <array>

#include <deform/record/jet_terms.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class NormalBranch final : public Probe {
 public:
  NormalBranch(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    terms_.clear();
    for (const JetTermUse& use : terms_with_normal(context.system)) {
      std::vector<std::string> branches = use.term->normal()->branches();
      if (!branches.empty()) terms_.push_back({use, std::move(branches)});
    }
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    if (terms_.empty()) return {{"normal_branch", "1"}};
    std::vector<ProbeColumn> columns;
    for (const Term& term : terms_)
      for (const std::string& branch : term.branches)
        columns.push_back({"normal_branch." + term.use.name + "." + branch, "1"});
    return columns;
  }

  void measure(const Frame& frame, Values figures) override {
    std::fill(figures.begin(), figures.end(), kNoFigure);
    std::size_t column = 0;
    for (const Term& term : terms_) {
      write_shares(term, frame, figures.subspan(column, term.branches.size()));
      column += term.branches.size();
    }
  }

 private:
  struct Term {
    JetTermUse use;
    std::vector<std::string> branches;
  };

  static void write_shares(const Term& term, const Frame& frame, Values shares) {
    const SampleSet& samples = *term.use.samples;
    const auto geometry = frame.geometry(samples);
    std::fill(shares.begin(), shares.end(), 0.0);
    double total = 0;
    std::array<std::uint8_t, kBlock> branch{};
    for (Index first = 0; first < samples.size(); first += kBlock) {
      const Index size = std::min(kBlock, samples.size() - first);
      for (const Pair ij : kPairs) {
        term.use.term->normal()->branch(geometry->block(first, size), ij,
                                        {branch.data(), static_cast<std::size_t>(size)});
        for (Index s = first; s < first + size; ++s) {
          if (!samples.computable(second(ij), s)) continue;
          const std::size_t b = branch[static_cast<std::size_t>(s - first)];
          if (b >= shares.size())
            throw Error(ExitCode::plugin_failed,
                        "the normal estimator of '" + term.use.name + "' reports branch number " +
                            std::to_string(b) + " but names only " + std::to_string(shares.size()));
          const double weight = samples.weights()[static_cast<std::size_t>(s)] * multiplicity(ij);
          shares[b] += weight;
          total += weight;
        }
      }
    }
    for (double& share : shares) share = total > 0 ? share / total : kNoFigure;
  }

  std::vector<Term> terms_;
};

}  // namespace

DEFORM_PLUGIN(NormalBranch, NoParameters, .name = "normal_branch", .version = "1.0",
              .summary =
                  "Share of the area, over samples and all four ij, in each case of a normal "
                  "estimator's rule, at the present state",
              .formula = "sum of A over (sample, ij) in the branch / sum of A over all",
              .source = "Wu and Melo (24)-(26)")
