/// Wavefront OBJ, one file a recorded step, for Blender and the like.
#include <Eigen/Geometry>

#include <deform/record/output.h>

#include "../output_file.h"

namespace {

using namespace deform;

/// (N × 3) unit normals of the nodes: the mean of the adjoining faces' normals, weighted by their
/// areas, so that they exist on every surface. Zero where all faces of a node are crushed.
NodeVectors node_normals(const Faces& faces, const NodeVectors& r) {
  NodeVectors normals = NodeVectors::Zero(r.rows(), 3);
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f) {
    const auto begin = static_cast<std::size_t>(faces.begin[f]);
    const auto end = static_cast<std::size_t>(faces.begin[f + 1]);
    Vec3 twice_area = Vec3::Zero();  // Newell: right for polygons that are not plane
    const Vec3 origin = r.row(faces.nodes[begin]);
    for (std::size_t k = begin + 1; k + 1 < end; ++k) {
      const Vec3 a = r.row(faces.nodes[k]).transpose() - origin;
      const Vec3 b = r.row(faces.nodes[k + 1]).transpose() - origin;
      twice_area += a.cross(b);
    }
    for (std::size_t k = begin; k < end; ++k) normals.row(faces.nodes[k]) += twice_area;
  }
  for (Index a = 0; a < normals.rows(); ++a) {
    const double length = normals.row(a).norm();
    if (length > 0) normals.row(a) /= length;
  }
  return normals;
}

/// Text that goes to the file in large pieces.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path) : file_(path) { text_.reserve(2 * kPiece); }

  void vectors(const char* keyword, const NodeVectors& v) {
    for (Index a = 0; a < v.rows(); ++a) {
      text_ += keyword;
      for (Index c = 0; c < 3; ++c) {
        text_ += ' ';
        outputs::append_number(text_, v(a, c));
      }
      end_line();
    }
  }
  void faces(const Faces& faces) {
    for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f) {
      text_ += 'f';
      for (auto k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
        const long number = faces.nodes[static_cast<std::size_t>(k)] + 1L;  // OBJ counts from 1
        text_ += ' ';
        outputs::append_number(text_, number);
        text_ += "//";
        outputs::append_number(text_, number);
      }
      end_line();
    }
  }
  void commit() {
    file_.write(text_);
    file_.commit();
  }

 private:
  void end_line() {
    text_ += '\n';
    if (text_.size() < kPiece) return;
    file_.write(text_);
    text_.clear();
  }

  static constexpr std::size_t kPiece = 1 << 16;
  outputs::OutputFile file_;
  std::string text_;
};

class Obj final : public Output {
 public:
  Obj(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::string place() const override { return "obj"; }

  void begin(const RunContext& context) override {
    folder_ = context.folder / place();
    outputs::make_folder(folder_, context.resumed_at);
  }

  void write(const Frame& frame) override {
    const Faces& faces = frame.system.surface().faces();
    TextFile file(folder_ / outputs::numbered_name("surface", frame.step, "obj"));
    const NodeVectors positions = frame.positions();
    file.vectors("v", positions);
    file.vectors("vn", node_normals(faces, positions));
    file.faces(faces);
    file.commit();
  }

  void end() override {}  // every frame leaves its file complete

 private:
  std::filesystem::path folder_;
};

}  // namespace

DEFORM_PLUGIN(Obj, NoParameters, .name = "obj", .version = "1.0",
              .summary =
                  "Wavefront OBJ sequence obj/surface_000123.obj: positions (z up) [m], normals, "
                  "faces",
              .formula = "normals: area-weighted mean of the adjoining faces' normals",
              .source = "Wavefront OBJ")
