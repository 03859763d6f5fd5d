#include "record/node_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deform {
namespace {

using Scale = TrajectoryField::Scale;

/// A field's name, with the term's where there is more than one that it could be of.
std::string named(const std::string& field, const JetTermUse& use, bool alone) {
  return alone ? field : field + ", " + use.name;
}

/// Whether the angles and branches of its estimator are numbers of nodes.
bool has_normals(const JetTermUse& use) {
  return use.term->normal() != nullptr && use.samples->samples_are_nodes();
}

bool has_branches(const JetTermUse& use) {
  return has_normals(use) && !use.term->normal()->branches().empty();
}

/// Means of the samples at each node: by the area of a sample that D_0 gives to the node. NaN where
/// that is none.
std::vector<double> at_nodes(const SampleSet& samples, const std::vector<double>& values) {
  if (samples.samples_are_nodes()) return values;
  const auto n = static_cast<std::size_t>(samples.nodes());
  std::vector<double> sums(n), areas(n);
  for (Index s = 0; s < samples.size(); ++s) {
    const auto sample = static_cast<std::size_t>(s);
    const SampleSet::Stencil at = samples.stencil(s);
    for (std::size_t k = 0; k < at.nodes.size(); ++k) {
      const auto node = static_cast<std::size_t>(at.nodes[k]);
      const double area =
          samples.weights()[sample] * at.d[k][static_cast<std::size_t>(slot(Derivative::d0))];
      sums[node] += area * values[sample];
      areas[node] += area;
    }
  }
  for (std::size_t a = 0; a < n; ++a)
    sums[a] = areas[a] > 0 ? sums[a] / areas[a] : std::numeric_limits<double>::quiet_NaN();
  return sums;
}

}  // namespace

NodeFields::NodeFields(const System& system) : terms_(jet_terms(system)) {
  const SampleSet& bending = system.surface().samples(SampleRole::bending);
  if (bending.samples_are_nodes()) curved_ = &bending;
  if (curved_ != nullptr) {
    for (const char* name : {"B_11", "B_12", "B_22"})
      fields_.push_back({name, "1/m", Scale::diverging});
  }
  const auto with_normal = std::ranges::count_if(terms_, has_normals);
  for (const JetTermUse& use : terms_) {
    fields_.push_back({"energy density, " + use.name, "J/m²", Scale::sequential});
    if (!has_normals(use)) continue;
    fields_.push_back({named("normal angle", use, with_normal == 1), "rad", Scale::sequential});
    if (has_branches(use)) {
      fields_.push_back({named("branch", use, with_normal == 1), "", Scale::categorical,
                         use.term->normal()->branches()});
    }
  }
  with_contact_ = system.contact().bodies() > 0;
  if (with_contact_) {
    fields_.push_back({"contact pressure", "Pa", Scale::sequential});
    fields_.push_back({"friction", "Pa", Scale::sequential});
  }
  values_.resize(fields_.size());
}

const std::vector<std::vector<float>>& NodeFields::evaluate(const Frame& frame) {
  auto next = values_.begin();
  const auto put = [&next](const auto& values) {
    next->assign(values.begin(), values.end());
    ++next;
  };
  if (curved_ != nullptr) {
    const auto curved = frame.geometry(*curved_);
    for (const Pair ij : kPairs) put(curved->all().B(ij));
  }
  for (const JetTermUse& use : terms_) {
    put(at_nodes(*use.samples, frame.system.terms().energy_density(use.number, frame.state.r)));
    if (!has_normals(use)) continue;
    add_angles(use, frame, *next++);
    if (has_branches(use)) add_branches(use, frame, *next++);
  }
  if (with_contact_) {
    const ContactReport& contact = frame.system.step_report().contact;
    const NodeValues& areas = frame.system.areas();
    const Index nodes = frame.system.nodes();
    for (const NodeVectors& force : {contact.normal_force(nodes), contact.friction_force(nodes)})
      put(NodeValues(force.rowwise().norm().cwiseQuotient(areas)));
  }
  return values_;
}

/// The largest of the angles between n_ij and n, over the pairs that exist: coefficients of the
/// previous state on the present jets, as the step had them; none at first, where there is no
/// previous state.
void NodeFields::add_angles(const JetTermUse& use, const Frame& frame, std::vector<float>& values) {
  const auto geometry = frame.geometry(*use.samples);
  const Geometry& now = *geometry;
  values.assign(static_cast<std::size_t>(now.size()), std::numeric_limits<float>::quiet_NaN());
  if (frame.step == 0) return;
  const auto previous = frame.previous_geometry(*use.samples);
  const Geometry& lagged = *previous;
  const ConstVectors n = now.all().n();
  for (const Pair ij : kPairs) {
    estimate_normals(use, lagged, now, ij, estimates_);
    for (Index s = 0; s < now.size(); ++s) {
      const double angle = angle_between(estimates_.row(s), n[s]);
      float& value = values[static_cast<std::size_t>(s)];
      if (!std::isnan(angle)) value = std::fmax(value, static_cast<float>(angle));
    }
  }
}

/// The branch of the pair whose second derivative exists and whose branch has the highest number.
void NodeFields::add_branches(const JetTermUse& use, const Frame& frame,
                              std::vector<float>& values) {
  const auto geometry = frame.geometry(*use.samples);
  const Geometry& now = *geometry;
  values.assign(static_cast<std::size_t>(now.size()), std::numeric_limits<float>::quiet_NaN());
  std::array<std::uint8_t, kBlock> branch{};
  for (Index first = 0; first < now.size(); first += kBlock) {
    const Index size = std::min(kBlock, now.size() - first);
    for (const Pair ij : kPairs) {
      use.term->normal()->branch(now.block(first, size), ij,
                                 {branch.data(), static_cast<std::size_t>(size)});
      for (Index i = 0; i < size; ++i) {
        if (!use.samples->computable(second(ij), first + i)) continue;
        float& value = values[static_cast<std::size_t>(first + i)];
        value = std::fmax(value, static_cast<float>(branch[static_cast<std::size_t>(i)]));
      }
    }
  }
}

}  // namespace deform
