#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <deform/log.h>
#include <deform/surface/shape.h>
#include <deform/surface/surface.h>

#include "coarsening.h"
#include "jets.h"
#include "polygons.h"
#include "triangles.h"

namespace {
using namespace deform;

struct Parameters {
  std::filesystem::path path;
  double scale = 1;
  Vec3 rotation = Vec3::Zero(), translation = Vec3::Zero();
  bool repair = false;
  PluginUse initial{.kind = PluginKind::shape, .name = ""};

  static void declare(Declaration<Parameters>& d) {
    d("path", &Parameters::path, "", "mesh at rest: .obj, .ply, .stl, .off, .gltf or .glb")
        .required();
    d("scale", &Parameters::scale, "1", "what the file's lengths are multiplied by (mm: 0.001)")
        .above(0);
    d("rotation", &Parameters::rotation, "rad", "of the scaled mesh: axis times angle");
    d("translation", &Parameters::translation, "m", "of the rotated mesh");
    d("repair", &Parameters::repair, "",
      "mends doubled vertices and polygons, those without area or use, and directions round "
      "polygons, and says so; without it they are refused");
    d("initial", &Parameters::initial, "",
      "shape at first; the rest shape when absent; from parameters only where the mesh lies in a "
      "plane");
  }
};

void move(const Parameters& p, NodeVectors& r) {
  const double angle = p.rotation.norm();
  const Eigen::Matrix3d turn = angle > 0
                                   ? Eigen::AngleAxisd(angle, p.rotation / angle).toRotationMatrix()
                                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  r = (p.scale * r * turn.transpose()).eval();
  r.rowwise() += p.translation.transpose();
}

/// Triangles from a file. Its membrane samples are the triangles, its bending samples the nodes;
/// each has a chart of its own, orthonormal at rest, unless the mesh lies in a plane.
class Mesh final : public Surface {
 public:
  Mesh(const Parameters& p, const Setup& setup) {
    mesh::Polygons polygons = mesh::read_polygons(setup.resolve(p.path));
    move(p, polygons.positions);
    std::vector<std::string> mended;
    triangles_ = mesh::make_triangles(std::move(polygons), p.path.string(), p.repair, mended);
    for (const std::string& what : mended) log::info(p.path.string() + ": " + what);
    axes_ = mesh::axes_of_plane(triangles_);
    areas_ = mesh::node_areas(triangles_);
    parameters_ = Eigen::MatrixX2d::Zero(triangles_.nodes(), 2);
    if (axes_) parameters_ = triangles_.positions * *axes_;
    for (const mesh::Triangle& t : triangles_.all) {
      faces_.nodes.insert(faces_.nodes.end(), t.begin(), t.end());
      faces_.begin.push_back(static_cast<std::int32_t>(faces_.nodes.size()));
    }
    membrane_ = mesh::triangle_samples(triangles_, axes_);
    bending_ = mesh::node_samples(triangles_, areas_, axes_);
    initial_ = p.initial.name.empty() ? triangles_.positions : positions(p.initial, setup);
  }

  [[nodiscard]] Index nodes() const override { return triangles_.nodes(); }
  [[nodiscard]] bool has_chart() const override { return axes_.has_value(); }
  [[nodiscard]] const Eigen::MatrixX2d& parameters() const override { return parameters_; }
  [[nodiscard]] const NodeValues& areas() const override { return areas_; }
  [[nodiscard]] NodeValues rest_areas() const override { return areas_; }
  [[nodiscard]] const NodeVectors& rest() const override { return triangles_.positions; }
  [[nodiscard]] const NodeVectors& initial() const override { return initial_; }
  [[nodiscard]] const Faces& faces() const override { return faces_; }
  [[nodiscard]] const SampleSet& samples(SampleRole role) const override {
    return role == SampleRole::membrane ? membrane_ : bending_;
  }
  [[nodiscard]] std::vector<std::string> boundary_names() const override {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < triangles_.borders.size(); ++k)
      names.push_back("border_" + std::to_string(k + 1));
    return names;
  }
  [[nodiscard]] std::vector<std::string> corner_names() const override { return {}; }
  [[nodiscard]] std::vector<Index> boundary(const std::string& name) const override {
    const std::vector<std::string> names = boundary_names();
    const auto at = std::ranges::find(names, name);
    if (at == names.end()) return {};
    std::vector<Index> nodes = triangles_.borders[static_cast<std::size_t>(at - names.begin())];
    std::ranges::sort(nodes);
    return nodes;
  }
  [[nodiscard]] std::vector<Index> corner(const std::string& /*name*/) const override { return {}; }
  [[nodiscard]] std::vector<Prolongation> coarsening() const override {
    return mesh::coarsening(triangles_);
  }

 private:
  [[nodiscard]] NodeVectors positions(const PluginUse& use, const Setup& setup) const {
    if (!axes_ && use.name != "file")
      throw InputError(
          {Problem{"/initial", "shape \"" + use.name +
                                   "\" is made of parameters, which a mesh that lies in no plane "
                                   "does not have; expected \"file\": a line x y z a vertex"}});
    const Vec2 size = parameters_.colwise().maxCoeff() - parameters_.colwise().minCoeff();
    return setup.create<Shape>(use)->positions(parameters_, size);
  }

  mesh::Triangles triangles_;
  std::optional<mesh::Axes> axes_;  // of its plane
  NodeValues areas_;
  Eigen::MatrixX2d parameters_;
  Faces faces_;
  SampleSet membrane_, bending_;
  NodeVectors initial_;
};

}  // namespace

DEFORM_PLUGIN(Mesh, Parameters, .name = "mesh", .version = "0.1",
              .summary = "triangles from a file, of any topology", .formula = "",
              .source = "first derivatives: linear triangles; second: least squares over rings")
