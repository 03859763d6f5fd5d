#include "solve/assembly/jet_assembler.h"

#include <algorithm>
#include <span>

#include "deform/kernel.h"
#include "deform/parallel.h"

#include "model/numerical_stress.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Rows of a matrix or a force that one task gathers.
constexpr Index kRows = 64;
/// Sample fields that one term may have differenced.
constexpr int kMostFields = 8;

/// s += k r of vectors, k one a sample.
DEFORM_KERNEL void add_products(Index size, const double* __restrict k,
                                const double* __restrict r_x, const double* __restrict r_y,
                                const double* __restrict r_z, double* __restrict x,
                                double* __restrict y, double* __restrict z) {
  for (Index i = 0; i < size; ++i) {
    x[i] += k[i] * r_x[i];
    y[i] += k[i] * r_y[i];
    z[i] += k[i] * r_z[i];
  }
}
/// The same, k one for all.
DEFORM_KERNEL void add_multiples(Index size, double k, const double* __restrict r_x,
                                 const double* __restrict r_y, const double* __restrict r_z,
                                 double* __restrict x, double* __restrict y, double* __restrict z) {
  for (Index i = 0; i < size; ++i) {
    x[i] += k * r_x[i];
    y[i] += k * r_y[i];
    z[i] += k * r_z[i];
  }
}

/// Rows of the operator that are made at once, at most.
constexpr Index kLanes = 32;

/// s += l x.
DEFORM_KERNEL void add_multiple(Index size, double l, const double* __restrict x,
                                double* __restrict s) {
  for (Index i = 0; i < size; ++i) s[i] += l * x[i];
}

/// Only what the framework has storage for may be named.
std::vector<Coupling> couplings_of(const JetAssembler::Term& t) {
  const auto couplings =
      guarded(t.origin, "declaring couplings", [&] { return t.term->couplings(); });
  for (const auto& [m, n] : couplings) {
    const bool is_known = slot(m) < kChannels && slot(n) > 0 && slot(n) < kDerivatives;
    if (!is_known)
      throw PluginFailure(
          "plugin " + t.origin + " declares the coupling (" + std::to_string(slot(m)) + ", " +
          std::to_string(slot(n)) +
          "), expected a channel from d0 to minus2 and a derivative from d1 to d22");
  }
  return couplings;
}

/// Whether a term may put stress on a channel.
bool may_use(const JetAssembler::Term& t, int m) {
  return m < kDerivatives || t.traits.strong_form;
}

/// Whether a term's stress is asked for without its couplings.
bool is_direct(const JetAssembler::Term& t, JetAssembler::Part part) {
  return t.traits.lagged == Lagged::none ||
         (t.traits.direct_stress && part == JetAssembler::Part::stress);
}

std::size_t fields_of(const JetAssembler::Term& t) {
  const int fields =
      guarded(t.origin, "declaring auxiliary fields", [&] { return t.term->auxiliary_fields(); });
  if (fields < 0 || fields > kMostFields)
    throw PluginFailure("plugin " + t.origin + " declares " + std::to_string(fields) +
                        " auxiliary fields, expected 0 to " + std::to_string(kMostFields));
  return static_cast<std::size_t>(fields);
}

}  // namespace

JetAssembler::JetAssembler(const SampleSet& samples, std::vector<Term> terms)
    : samples_(&samples), terms_(std::move(terms)), gather_(samples) {
  active_.fill(false);
  std::size_t fields = 0;
  for (const Term& t : terms_) {
    if (t.traits.strong_form && samples.field_differences() == nullptr)
      throw InputError("energy " + t.origin +
                       " needs differences of a field of samples, which this surface does not have "
                       "for its role");
    std::vector<std::size_t>& numbers = of_term_.emplace_back();
    for (const Coupling& coupling : couplings_of(t)) {
      const auto at = std::ranges::find(couplings_, coupling);
      const std::size_t number = static_cast<std::size_t>(at - couplings_.begin());
      if (at == couplings_.end()) couplings_.push_back(coupling);
      if (std::ranges::find(numbers, number) == numbers.end()) numbers.push_back(number);
    }
    mark_active(t);
    fields += fields_of_.emplace_back(fields_of(t));
  }
  const auto m = static_cast<std::size_t>(samples.stride());
  k_.resize(couplings_.size() * m);
  sigma_.resize(3 * kChannels * m);
  auxiliary_.resize(fields * m);
  std::size_t field = 0;
  for (const std::size_t own : fields_of_) {
    auto& views = auxiliary_of_.emplace_back();
    for (std::size_t f = 0; f < own; ++f, ++field)
      views.emplace_back(auxiliary_.data() + field * m, static_cast<std::size_t>(samples.size()));
  }
}

/// A stress may use every transposed derivative, but where it is the derivative of an energy: then
/// those that this depends on; the strong form's channels only if the term says so.
void JetAssembler::mark_active(const Term& t) {
  if (!t.traits.potential) {
    for (int m = 0; m < kChannels; ++m)
      if (may_use(t, m)) active_[static_cast<std::size_t>(m)] = true;
    return;
  }
  for (const auto& [m, n] : couplings_) active_[static_cast<std::size_t>(slot(m))] = true;
  for (const Derivative d :
       guarded(t.origin, "saying what it depends on", [&] { return t.term->dependence(); }))
    if (slot(d) >= 0 && slot(d) < kDerivatives) active_[static_cast<std::size_t>(slot(d))] = true;
}

const JetAssembler::Term* JetAssembler::find(std::size_t number) const {
  const auto at = std::ranges::find(terms_, number, &Term::number);
  return at == terms_.end() ? nullptr : &*at;
}

Geometry::Detail JetAssembler::detail() const {
  const auto of = [](const JetTerm& term) {
    const bool has_normals = std::ranges::any_of(
        kTangents, [&](Tangent kind) { return term.tangent_shape(kind) == TangentShape::normal; });
    return std::max(term.reads(), has_normals ? Geometry::Detail::first : Geometry::Detail::none);
  };
  auto most = Geometry::Detail::none;
  for (const Term& t : terms_)
    most = std::max(most, guarded(t.origin, "saying what it reads", [&] { return of(*t.term); }));
  return most;
}

SampleBlock JetAssembler::sample_block(const Geometries& g, const Term& term, Index first,
                                       Index size) const {
  const Geometry& now = g.mean != nullptr && term.traits.strains ? *g.mean : g.now;
  const Geometry& lagged = &g.lagged == &g.now ? now : g.lagged;
  return {.now = now.block(first, size),
          .lagged = lagged.block(first, size),
          .rest = g.rest.block(first, size),
          .origin = (g.origin != nullptr ? *g.origin : g.rest).block(first, size),
          .differences = samples_->field_differences(),
          .auxiliary = {}};
}

void JetAssembler::evaluate(const Geometries& geometries, Part part, const Term* only,
                            const Prepare& prepare) {
  if (terms_.empty()) return;
  std::size_t offset = 0;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    if (only == nullptr || only == &terms_[t]) evaluate_auxiliary(geometries, t, offset);
    offset += fields_of_[t] * static_cast<std::size_t>(samples_->stride());
  }
  parallel_blocks(samples_->size(), kBlock, [&](Index first, Index size) {
    if (prepare) prepare(first, size);
    evaluate_block(geometries, part, only, first, size);
  });
}

bool JetAssembler::evaluates_by_blocks() const {
  return !terms_.empty() && std::ranges::all_of(fields_of_, [](std::size_t n) { return n == 0; });
}

void JetAssembler::evaluate_auxiliary(const Geometries& g, std::size_t number, std::size_t offset) {
  const Term& term = terms_[number];
  const std::size_t fields = fields_of_[number];
  if (fields == 0) return;
  parallel_blocks(samples_->size(), kBlock, [&](Index first, Index size) {
    std::array<Values, kMostFields> out;
    for (std::size_t f = 0; f < fields; ++f)
      out[f] = {auxiliary_.data() + offset + f * static_cast<std::size_t>(samples_->stride()) +
                    static_cast<std::size_t>(first),
                static_cast<std::size_t>(size)};
    guarded(term.origin, "computing auxiliary fields", [&] {
      term.term->auxiliary(sample_block(g, term, first, size), {out.data(), fields});
    });
  });
}

void JetAssembler::evaluate_block(const Geometries& g, Part part, const Term* only, Index first,
                                  Index size) {
  const auto is_evaluated = [&](const Term& t) { return only == nullptr || only == &t; };
  const bool has_couplings = std::ranges::any_of(
      terms_, [&](const Term& t) { return is_evaluated(t) && !is_direct(t, part); });
  if (has_couplings)
    for (std::size_t c = 0; c < couplings_.size(); ++c) std::fill_n(coupling(c) + first, size, 0.0);
  for (int m = 0; m < kChannels; ++m) {
    if (!active_[static_cast<std::size_t>(m)]) continue;
    const Vectors s = sigma(m).from(first);
    for (double* component : {s.x, s.y, s.z}) std::fill_n(component, size, 0.0);
  }
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    if (!is_evaluated(terms_[t])) continue;
    SampleBlock block = sample_block(g, terms_[t], first, size);
    block.auxiliary = auxiliary_of_[t];
    evaluate_term(t, part, block);
  }
  if (has_couplings && part != Part::couplings_and_constant)
    add_affine_part(g.now.block(first, size));
}

void JetAssembler::evaluate_term(std::size_t number, Part part, const SampleBlock& block) {
  const Term& term = terms_[number];
  AffineStress::ConstantTable channels;
  for (int m = 0; m < kChannels; ++m)
    if (may_use(term, m)) channels[static_cast<std::size_t>(m)] = sigma(m).from(block.first());
  if (is_direct(term, part)) {
    const Stress stress{channels};
    guarded(term.origin, "computing its stress", [&] { term.term->stress(block, stress); });
    return;
  }
  AffineStress::CouplingTable table{};
  for (const std::size_t c : of_term_[number]) {
    const auto& [m, n] = couplings_[c];
    table[static_cast<std::size_t>(slot(m))][static_cast<std::size_t>(slot(n))] =
        coupling(c) + block.first();
  }
  guarded(term.origin, "computing its lagged stress",
          [&] { term.term->affine_stress(block, AffineStress(table, channels, block.size())); });
}

/// σ_m = c_m + Σ_n k_mn D_n r: the c_m are there already.
void JetAssembler::add_affine_part(const GeometryBlock& now) {
  for (std::size_t c = 0; c < couplings_.size(); ++c) {
    const auto& [m, n] = couplings_[c];
    const double* k = coupling(c) + now.first();
    const ConstVectors r = now.r(n);
    const Vectors s = sigma(slot(m)).from(now.first());
    add_products(now.size(), k, r.x, r.y, r.z, s.x, s.y, s.z);
  }
}

void JetAssembler::add_force(NodeVectors& f) const {
  if (terms_.empty()) return;
  parallel_blocks(gather_.nodes(), kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size;) {
      const Index end = std::min(gather_.run_end(a), first + size);
      add_force_of_run(a, end - a, f);
      a = end;
    }
  });
}

void JetAssembler::add_force_of_run(Index a, Index size, NodeVectors& f) const {
  const Index m_samples = samples_->stride();
  std::array<std::array<double, kRows>, 3> sum{};
  const GatherTable::Row row = gather_.row(a);
  for (std::size_t e = 0; e < row.samples.size(); ++e)
    for (int m = 0; m < kChannels; ++m) {
      const double l = row.l[e][static_cast<std::size_t>(m)];
      if (!active_[static_cast<std::size_t>(m)] || l == 0) continue;
      const double* x = sigma_.data() + 3 * m * m_samples + row.samples[e];
      add_multiples(size, l, x, x + m_samples, x + 2 * m_samples, sum[0].data(), sum[1].data(),
                    sum[2].data());
    }
  for (int c = 0; c < 3; ++c)
    f.col(c).segment(a, size) -=
        Eigen::Map<const Eigen::VectorXd>(sum[static_cast<std::size_t>(c)].data(), size);
}

void JetAssembler::bind(const SparseMatrix& pattern) {
  slot_begin_.assign(1, 0);
  slot_.clear();
  for (Index a = 0; a < gather_.nodes(); ++a) {
    const auto begin = pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a)];
    const auto end = pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a) + 1];
    for (const std::int32_t s : gather_.row(a).samples) {
      for (const std::int32_t b : samples_->stencil(s).nodes) {
        const auto at = std::lower_bound(begin, end, b);
        const bool there = at != end && *at == b;
        if (there && at - begin >= kNoSlot)
          throw Error(ExitCode::internal_error, "a matrix row has more than 65534 entries");
        slot_.push_back(there ? static_cast<std::uint16_t>(at - begin) : kNoSlot);
      }
      slot_begin_.push_back(slot_.size());
    }
  }
  operator_run_end_.resize(static_cast<std::size_t>(gather_.nodes()));
  for (Index a = gather_.nodes() - 1; a >= 0; --a) {
    const bool is_last = a + 1 == gather_.nodes() || !operator_goes_on(pattern, a);
    operator_run_end_[static_cast<std::size_t>(a)] =
        is_last ? a + 1 : operator_run_end_[static_cast<std::size_t>(a) + 1];
  }
}

/// Rows whose entries are at the same places, made of samples that are alike.
bool JetAssembler::operator_goes_on(const SparseMatrix& pattern, Index a) const {
  if (gather_.run_end(a) == a + 1) return false;
  const auto slots = [&](Index row) {
    const auto first = slot_begin_[gather_.first_pair(row)];
    const auto last = slot_begin_[gather_.first_pair(row) + gather_.row(row).samples.size()];
    return std::span(slot_).subspan(first, last - first);
  };
  const auto size = [&](Index row) {
    return pattern.row_begin[static_cast<std::size_t>(row) + 1] -
           pattern.row_begin[static_cast<std::size_t>(row)];
  };
  return size(a) == size(a + 1) && std::ranges::equal(slots(a), slots(a + 1)) &&
         std::ranges::all_of(gather_.row(a).samples,
                             [&](std::int32_t s) { return samples_->run_end(s) > s + 1; });
}

/// Rows a … a+size−1, which are alike, at most kLanes: entry q of the k-th goes to
/// rows[q·kLanes + k].
void JetAssembler::add_operator_to(Index a, Index size, double* rows) const {
  const GatherTable::Row row = gather_.row(a);
  for (std::size_t e = 0; e < row.samples.size(); ++e) {
    // Row a of L_mᵀ k_mn, summed over the channels m, for each derivative n …
    std::array<std::array<double, kLanes>, kDerivatives> left;
    std::array<bool, kDerivatives> has_part{};
    for (std::size_t c = 0; c < couplings_.size(); ++c) {
      const auto& [m, n] = couplings_[c];
      const double l = row.l[e][static_cast<std::size_t>(slot(m))];
      if (l == 0) continue;
      auto& sum = left[static_cast<std::size_t>(slot(n))];
      bool& has = has_part[static_cast<std::size_t>(slot(n))];
      if (!has) std::fill_n(sum.begin(), size, 0.0);
      has = true;
      add_multiple(size, l, coupling(c) + row.samples[e], sum.data());
    }
    // … times the rows of D_n at the sample.
    const SampleSet::Stencil at = samples_->stencil(row.samples[e]);
    const std::uint16_t* slots = slot_.data() + slot_begin_[gather_.first_pair(a) + e];
    for (std::size_t b = 0; b < at.nodes.size(); ++b) {
      if (slots[b] == kNoSlot) continue;
      std::array<double, kLanes> sum;
      std::fill_n(sum.begin(), size, 0.0);
      for (std::size_t n = 0; n < kDerivatives; ++n)
        if (has_part[n] && at.d[b][n] != 0)
          add_multiple(size, at.d[b][n], left[n].data(), sum.data());
      add_multiple(size, 1, sum.data(), rows + slots[b] * kLanes);
    }
  }
}

void JetAssembler::add_operator(SparseMatrix& k) const {
  parallel_blocks(gather_.nodes(), kRows, [&](Index first, Index size) {
    // Kept by each thread from call to call: no allocation once it is large enough.
    thread_local std::vector<double> rows;
    for (Index a = first; a < first + size;) {
      const Index end =
          std::min({operator_run_end_[static_cast<std::size_t>(a)], first + size, a + kLanes});
      const std::int32_t* const begin = k.row_begin.data() + a;
      const Index width = begin[1] - begin[0];
      rows.resize(std::max(rows.size(), static_cast<std::size_t>(width * kLanes)));
      const auto each = [&](const auto& action) {
        for (Index q = 0; q < end - a; ++q)
          for (Index i = 0; i < width; ++i)
            action(k.value[static_cast<std::size_t>(begin[q] + i)],
                   rows[static_cast<std::size_t>(i * kLanes + q)]);
      };
      each([](double of_matrix, double& of_rows) { of_rows = of_matrix; });
      add_operator_to(a, end - a, rows.data());
      each([](double& of_matrix, double of_rows) { of_matrix = of_rows; });
      a = end;
    }
  });
}

bool JetAssembler::is_numerical(const Term& term, const Geometries& geometries) const {
  if (term.traits.lagged != Lagged::none || samples_->size() == 0) return false;
  return guarded(term.origin, "computing its stress", [&] {
    return has_numerical_stress(*term.term, sample_block(geometries, term, 0, 1));
  });
}

void JetAssembler::energy_density(const Term& term, const Geometries& geometries,
                                  Values density) const {
  parallel_blocks(samples_->size(), kBlock, [&](Index first, Index size) {
    const Values block =
        density.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size));
    std::ranges::fill(block, 0.0);
    guarded(term.origin, "computing its energy",
            [&] { term.term->energy_density(sample_block(geometries, term, first, size), block); });
  });
}

void JetAssembler::node_normals(const Geometry& now, NodeVectors& normals) const {
  const ConstVectors n = now.all().n();
  parallel_blocks(gather_.nodes(), kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a) {
      const GatherTable::Row row = gather_.row(a);
      Vec3 sum = Vec3::Zero();
      for (std::size_t e = 0; e < row.samples.size(); ++e) sum += row.l[e][0] * n[row.samples[e]];
      const double length = sum.norm();
      normals.row(a) = length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
    }
  });
}

}  // namespace deform
