/// ParaView's format: one .vtp file a recorded step, and .pvd files with the times.
#include <list>
#include <utility>

#include <deform/record/jet_terms.h>
#include <deform/record/output.h>

#include "output_file.h"
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

  void add(const std::filesystem::path& folder, long step, double time) {
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
    outputs::OutputFile file(folder / (stem_ + ".pvd"));
    file.write(text);
    file.commit();
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

/// The fields of one sample set, gathered for a frame. What a VtkPolyData refers to lives here.
class SampleFields {
 public:
  SampleFields(const SampleSet& samples, std::vector<JetTermUse> terms)
      : samples_(&samples), terms_(std::move(terms)) {}

  [[nodiscard]] const SampleSet& samples() const { return *samples_; }

  void add_to(VtkPolyData& data, const Frame& frame, bool with_geometry) {
    kept_values_.clear();
    kept_vectors_.clear();
    const Geometry& now = frame.system.geometry(*samples_);
    if (with_geometry) add_geometry(data, now.all(), *samples_);
    // The coefficients of the step just done; at the first frame there is no previous state.
    const Geometry& lagged = frame.step == 0 ? now : frame.system.previous_geometry(*samples_);
    for (const JetTermUse& use : terms_) {
      kept_values_.push_back(frame.system.energy_density(use.number));
      data.add("energy_" + use.name, kept_values_.back().data());
      if (use.term->normal() == nullptr) continue;
      for (const Pair ij : kPairs) {
        estimate_normals(use, lagged, now, ij, kept_vectors_.emplace_back());
        data.add("n_" + kPairNames[static_cast<std::size_t>(slot(ij))] + "_" + use.name,
                 rows_from(std::as_const(kept_vectors_.back()), 0));
      }
    }
  }

 private:
  /// A component of B that no sample of the set has is left out: its zeros would say "flat".
  static void add_geometry(VtkPolyData& data, const GeometryBlock& g, const SampleSet& samples) {
    data.add("n", g.n());
    std::vector<const double*> G, B;
    std::vector<std::string> names_of_B;
    for (const Pair ij : kPairs) {
      G.push_back(g.G(ij).data());
      if (!is_anywhere(samples, second(ij))) continue;
      B.push_back(g.B(ij).data());
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
  std::list<std::vector<double>> kept_values_;
  std::list<NodeVectors> kept_vectors_;
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

  void begin(const RunContext& context) override {
    folder_ = context.folder / "vtk";
    outputs::make_folder(folder_);
    on_nodes_.clear();
    clouds_.clear();
    const std::vector<JetTermUse> terms = jet_terms(context.system);
    const Surface& surface = context.system.surface();
    const SampleSet& bending = surface.samples(SampleRole::bending);
    const SampleSet& membrane = surface.samples(SampleRole::membrane);
    take(bending, terms, "samples");
    if (&membrane != &bending) take(membrane, terms, "membrane_samples");
    restore();
  }

  void write(const Frame& frame) override {
    write_surface(frame);
    for (Cloud& cloud : clouds_) write_cloud(cloud, frame);
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
  void take(const SampleSet& samples, std::vector<JetTermUse> terms, const std::string& stem) {
    std::erase_if(terms, [&](const JetTermUse& use) { return use.samples != &samples; });
    SampleFields fields(samples, std::move(terms));
    if (samples.samples_are_nodes())
      on_nodes_.push_back(std::move(fields));
    else
      clouds_.push_back({std::move(fields), Collection(stem)});
  }

  void write_surface(const Frame& frame) {
    const NodeVectors displacement = frame.state.r - frame.system.rest();
    VtkPolyData data(rows_from(frame.state.r, 0), frame.state.r.rows(), single_precision_);
    data.polygons(frame.system.surface().faces());
    data.add("velocity", rows_from(frame.state.v, 0));
    data.add("displacement", rows_from(displacement, 0));
    for (SampleFields& fields : on_nodes_)
      fields.add_to(data, frame, &fields == &on_nodes_.front());
    data.write(folder_ / surface_.file_of(frame.step), frame.state.time);
    surface_.add(folder_, frame.step, frame.state.time);
  }

  void write_cloud(Cloud& cloud, const Frame& frame) {
    const NodeVectors places = cloud.fields.samples().apply(Derivative::d0, frame.state.r);
    VtkPolyData data(rows_from(places, 0), places.rows(), single_precision_);
    data.vertices();
    cloud.fields.add_to(data, frame, true);
    data.write(folder_ / cloud.collection.file_of(frame.step), frame.state.time);
    cloud.collection.add(folder_, frame.step, frame.state.time);
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
