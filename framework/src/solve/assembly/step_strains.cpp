#include "deform/solve/step_strains.h"

#include <utility>

#include "deform/solve/evaluator.h"

#include "solve/assembly/assembly.h"
#include "solve/assembly/step_strains_impl.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

/// Room for one geometry a set.
void make_room(const std::vector<SetTerms>& sets, std::vector<Geometry>& geometries) {
  if (geometries.size() == sets.size()) return;
  geometries.clear();
  for (const SetTerms& set : sets) geometries.emplace_back(set.assembler.samples());
}

}  // namespace

void StepStrains::Impl::update_mean(const StateGeometry& middle) {
  if (middle_r.rows() == middle.r.rows() && middle_r == middle.r) return;
  const Stopwatch watch(&StepTimes::geometry, "geometry of a step");
  to_r = 2 * middle.r - from_r;
  for (std::size_t i = 0; i < terms->sets().size(); ++i) {
    terms->sets()[i].compute(to[i], to_r);
    mean[i].make_mean(middle.of_set[i], from[i], to[i]);
  }
  middle_r = middle.r;
}

StepStrains::StepStrains() : impl_(std::make_unique<Impl>()) {}
StepStrains::~StepStrains() = default;
StepStrains::StepStrains(StepStrains&&) noexcept = default;
StepStrains& StepStrains::operator=(StepStrains&&) noexcept = default;

void StepStrains::reset() {
  impl_->version = 0;
  impl_->rate = 0;
  impl_->averages = false;
}

void StepStrains::measure_rates_from(const Evaluator& of, double rate, const NodeVectors& r,
                                     double s, const NodeVectors& earlier) {
  Impl& i = *impl_;
  i.bind(of.assembly().terms);
  if (!of.assembly().damping.is_any()) return;
  i.rate = rate;
  i.version = i.terms->next_version();
  const std::vector<SetTerms>& sets = i.terms->sets();
  make_room(sets, i.begun);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    sets[k].compute(i.begun[k], r);
    if (s == 0) continue;
    make_room(sets, i.earlier);
    sets[k].compute(i.earlier[k], earlier);
    i.begun[k].blend(s, i.earlier[k]);
  }
}

void StepStrains::average_from(const Evaluator& of, const NodeVectors& r) {
  Impl& i = *impl_;
  i.bind(of.assembly().terms);
  i.averages = true;
  i.version = i.terms->next_version();
  i.from_r = r;
  i.middle_r.resize(0, 3);
  const std::vector<SetTerms>& sets = i.terms->sets();
  for (std::vector<Geometry>* room : {&i.from, &i.to, &i.mean}) make_room(sets, *room);
  for (std::size_t k = 0; k < sets.size(); ++k) sets[k].compute(i.from[k], r);
  i.tuple_energies.clear();
  for (const TupleAssembler& t : i.terms->tuples())
    i.tuple_energies.push_back(t.averages() ? t.energies(r) : std::vector<double>());
}

/// Whose sets the geometries are of.
void StepStrains::Impl::bind(ModelTerms& to_terms) {
  if (terms == &to_terms) return;
  for (std::vector<Geometry>* all : {&begun, &earlier, &from, &to, &mean}) all->clear();
  terms = &to_terms;
}

}  // namespace deform
