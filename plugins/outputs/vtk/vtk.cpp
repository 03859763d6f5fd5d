/// ParaView's format: one .vtp file a recorded step, and .pvd files with the times.
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <utility>

#include <deform/record/jet_terms.h>
#include <deform/record/output.h>

#include "../../output_file.h"
#include "vtk_poly_data.h"

namespace {

using namespace deform;
using outputs::VtkPolyData;

struct Parameters {
  std::string precision = "double";

  static void declare(Declaration<Parameters>& d) {
    d("precision", &Parameters::precision, "", "precision of points and fields in the files")
        .one_of({"double", "single"});
  }
};

/// The .vtp files of a recorded sequence, by time. Rewritten whole after every frame, so that an
/// interrupted run can be opened.
class Collection {
 public:
  explicit Collection(std::string stem) : stem_(std::move(stem)) {}

  [[nodiscard]] std::string file_of(long step) const {
    return outputs::numbered_name(stem_, step, "vtp");
  }

  struct Text {
    std::filesystem::path file;
    std::string text;
    void write() const {
      outputs::OutputFile out(file);
      out.write(text);
      out.commit();
    }
  };
  /// What the .pvd file is after one more frame.
  [[nodiscard]] Text add(const std::filesystem::path& folder, long step, double time) {
    // A run that was resumed writes steps again that were written after its checkpoint.
    while (!steps_.empty() && steps_.back() >= static_cast<double>(step)) {
      steps_.pop_back();
      times_.pop_back();
    }
    steps_.push_back(static_cast<double>(step));
    times_.push_back(time);
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      text += "<DataSet timestep=\"";
      outputs::append_number(text, times_[i]);
      text += R"(" part="0" file=")" + file_of(static_cast<long>(steps_[i])) + "\"/>\n";
    }
    text += "</Collection>\n</VTKFile>\n";
    return {folder / (stem_ + ".pvd"), std::move(text)};
  }

  void save(Memory& memory) const {
    memory.put(stem_ + ".steps", steps_);
    memory.put(stem_ + ".times", times_);
  }
  void load(const Memory& memory) {
    const auto found = memory.entries().find(stem_ + ".steps");
    if (found == memory.entries().end()) return;
    for (const double step : found->second)
      if (!(step >= 0 && step < 1e15)) throw InputError("a number of steps in it is none");
    steps_ = found->second;
    times_ = memory.get(stem_ + ".times", steps_.size());
  }

 private:
  std::string stem_;
  std::vector<double> steps_, times_;
};

/// Copies of a frame's numbers: what a VtkPolyData refers to.
class Copies {
 public:
  const double* of(ConstValues values) {
    return numbers_.emplace_back(values.begin(), values.end()).data();
  }
  const double* of(std::vector<double> values) {
    return numbers_.emplace_back(std::move(values)).data();
  }
  ConstVectors of(ConstVectors v, Index size) {
    const auto copy = [&](const double* x) {
      return of(ConstValues(x, static_cast<std::size_t>(size)));
    };
    return {copy(v.x), copy(v.y), copy(v.z)};
  }
  NodeVectors& of(NodeVectors v) { return vectors_.emplace_back(std::move(v)); }

 private:
  std::list<std::vector<double>> numbers_;
  std::list<NodeVectors> vectors_;
};

/// One file of a frame, and the collection that it belongs to.
struct Shot {
  Copies copies;
  std::optional<VtkPolyData> data;
  std::filesystem::path file;
  double time = 0;
  Collection::Text collection;

  void write() const {
    data->write(file, time);
    collection.write();
  }
};

/// The fields of one sample set.
class SampleFields {
 public:
  SampleFields(const SampleSet& samples, std::vector<JetTermUse> terms)
      : samples_(&samples), terms_(std::move(terms)) {}

  [[nodiscard]] const SampleSet& samples() const { return *samples_; }

  void add_to(Shot& shot, const Frame& frame, bool with_geometry) const {
    VtkPolyData& data = *shot.data;
    const auto geometry = frame.geometry(*samples_);
    const Geometry& now = *geometry;
    if (with_geometry) add_geometry(shot, now.all(), *samples_);
    // The coefficients of the step just done; at the first frame there is no previous state.
    const auto previous = frame.step == 0 ? geometry : frame.previous_geometry(*samples_);
    const Geometry& lagged = *previous;
    for (const JetTermUse& use : terms_) {
      data.add("energy_" + use.name,
               shot.copies.of(frame.system.terms().energy_density(use.number, frame.state.r)));
      if (use.term->normal() == nullptr) continue;
      for (const Pair ij : kPairs) {
        NodeVectors& normals = shot.copies.of(NodeVectors());
        estimate_normals(use, lagged, now, ij, normals);
        data.add("n_" + kPairNames[static_cast<std::size_t>(slot(ij))] + "_" + use.name,
                 rows_from(std::as_const(normals), 0));
      }
    }
  }

 private:
  /// A component of B that no sample of the set has is left out: its zeros would say "flat".
  static void add_geometry(Shot& shot, const GeometryBlock& g, const SampleSet& samples) {
    VtkPolyData& data = *shot.data;
    data.add("n", shot.copies.of(g.n(), g.size()));
    std::vector<const double*> G, B;
    std::vector<std::string> names_of_B;
    for (const Pair ij : kPairs) {
      G.push_back(shot.copies.of(g.G(ij)));
      if (!is_anywhere(samples, second(ij))) continue;
      B.push_back(shot.copies.of(g.B(ij)));
      names_of_B.push_back(kPairNames[static_cast<std::size_t>(slot(ij))]);
    }
    data.add("G", std::move(G), kPairNames);
    if (!B.empty()) data.add("B", std::move(B), std::move(names_of_B));
  }

  static bool is_anywhere(const SampleSet& samples, Derivative d) {
    for (Index s = 0; s < samples.size(); ++s)
      if (samples.computable(d, s)) return true;
    return false;
  }

  inline static const std::vector<std::string> kPairNames{"11", "12", "22"};
  const SampleSet* samples_;
  std::vector<JetTermUse> terms_;
};

/// The samples of a set that are not the nodes, in files of their own.
struct Cloud {
  SampleFields fields;
  Collection collection;
};

class Vtk final : public Output {
 public:
  Vtk(const Parameters& parameters, const Setup& /*setup*/)
      : single_precision_(parameters.precision == "single") {}

  [[nodiscard]] std::string place() const override { return "vtk"; }

  void begin(const RunContext& context) override {
    folder_ = context.folder / place();
    outputs::make_folder(folder_, context.resumed_at);
    on_nodes_.clear();
    clouds_.clear();
    const std::vector<JetTermUse> terms = jet_terms(context.system);
    const Surface& surface = context.system.surface();
    const SampleSet& bending = surface.samples(SampleRole::bending);
    const SampleSet& membrane = surface.samples(SampleRole::membrane);
    add_set(bending, terms, "samples");
    if (&membrane != &bending) add_set(membrane, terms, "membrane_samples");
    restore();
  }

  void write(const Frame& frame) override { take(frame)(); }

  [[nodiscard]] std::function<void()> take(const Frame& frame) override {
    const auto shots = std::make_shared<std::list<Shot>>();
    take_surface(frame, shots->emplace_back());
    for (Cloud& cloud : clouds_) take_cloud(cloud, frame, shots->emplace_back());
    return [shots] {
      for (const Shot& shot : *shots) shot.write();
    };
  }

  void end() override {}  // every frame leaves the files complete

  void save(Memory& memory) const override {
    surface_.save(memory);
    for (const Cloud& cloud : clouds_) cloud.collection.save(memory);
  }

  void load(const Memory& memory) override {
    saved_ = memory;
    restore();
  }

 private:
  void add_set(const SampleSet& samples, std::vector<JetTermUse> terms, const std::string& stem) {
    std::erase_if(terms, [&](const JetTermUse& use) { return use.samples != &samples; });
    SampleFields fields(samples, std::move(terms));
    if (samples.samples_are_nodes())
      on_nodes_.push_back(std::move(fields));
    else
      clouds_.push_back({std::move(fields), Collection(stem)});
  }

  void take_surface(const Frame& frame, Shot& shot) {
    begin_shot(shot, frame, frame.positions(), surface_);
    shot.data->polygons(frame.system.surface().faces());
    shot.data->add("velocity", kept(shot, frame.state.v));
    shot.data->add("displacement", kept(shot, frame.positions() - frame.system.rest()));
    add_contact(shot, frame);
    for (const SampleFields& fields : on_nodes_)
      fields.add_to(shot, frame, &fields == &on_nodes_.front());
  }

  /// Mean forces of colliders in the last step [N]; not numbers where none is known.
  static void add_contact(Shot& shot, const Frame& frame) {
    if (frame.system.contact().bodies() == 0) return;
    const ContactReport& contact = frame.system.step_report().contact;
    const Index nodes = frame.system.nodes();
    shot.data->add("contact_force", kept(shot, contact.normal_force(nodes)));
    shot.data->add("friction_force", kept(shot, contact.friction_force(nodes)));
  }

  void take_cloud(Cloud& cloud, const Frame& frame, Shot& shot) {
    begin_shot(shot, frame, cloud.fields.samples().apply(Derivative::d0, frame.positions()),
               cloud.collection);
    shot.data->vertices();
    cloud.fields.add_to(shot, frame, true);
  }

  void begin_shot(Shot& shot, const Frame& frame, const NodeVectors& places,
                  Collection& collection) {
    shot.data.emplace(kept(shot, places), places.rows(), single_precision_);
    shot.file = folder_ / collection.file_of(frame.step);
    shot.time = frame.state.time;
    shot.collection = collection.add(folder_, frame.step, frame.state.time);
  }

  static ConstVectors kept(Shot& shot, NodeVectors v) {
    return rows_from(std::as_const(shot.copies.of(std::move(v))), 0);
  }

  // Whichever of begin and load comes last has both the collections and what they remember.
  void restore() {
    surface_.load(saved_);
    for (Cloud& cloud : clouds_) cloud.collection.load(saved_);
  }

  bool single_precision_;
  std::filesystem::path folder_;
  Collection surface_{"surface"};
  std::vector<SampleFields> on_nodes_;
  std::vector<Cloud> clouds_;
  Memory saved_;
};

}  // namespace

DEFORM_PLUGIN(Vtk, Parameters, .name = "vtk", .version = "1.0",
              .summary =
                  "ParaView series: vtk/surface.pvd with positions, velocity, displacement, "
                  "and n, G, B, energy densities [J/m²] and estimated normals at the samples "
                  "(where these are not the nodes in vtk/samples.pvd and, of the membrane, in "
                  "vtk/membrane_samples.pvd)",
              .formula =
                  "n_ij_<term>: previous coefficients on the present jet (at the first frame "
                  "the present ones); zero where r_ij does not exist",
              .source = "VTK XML PolyData, appended raw little-endian data")
