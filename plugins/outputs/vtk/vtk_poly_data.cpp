#include "vtk_poly_data.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>

#include "../../output_file.h"

namespace deform::outputs {
namespace {

static_assert(std::endian::native == std::endian::little, "appended data are written as they are");

std::string quoted(const std::string& key, const std::string& value) {
  std::string text = key;
  text.append("=\"").append(value).append("\"");
  return text;
}

/// The XML text; counts the offsets of the appended arrays, which must be written in the same
/// order.
class Header {
 public:
  Header& text(const std::string& more) {
    text_ += more;
    return *this;
  }

  void array(const std::string& type, const std::string& attributes, std::uint64_t bytes) {
    text("<DataArray ").text(quoted("type", type)).text(" ").text(attributes).text(" ");
    text("format=\"appended\" ").text(quoted("offset", std::to_string(offset_))).text("/>\n");
    offset_ += sizeof(std::uint64_t) + bytes;
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::uint64_t offset_ = 0;
};

void write_array(OutputFile& file, const void* data, std::uint64_t bytes) {
  file.write(&bytes, sizeof(bytes));
  file.write(data, bytes);
}

/// Components of separate arrays, interleaved point by point.
template <class Real>
void write_interleaved(OutputFile& file, const std::vector<const double*>& components,
                       Index count) {
  constexpr Index kChunk = 4096;
  const auto width = static_cast<Index>(components.size());
  std::vector<Real> chunk(static_cast<std::size_t>(std::min(kChunk, count) * width));
  for (Index first = 0; first < count; first += kChunk) {
    const Index size = std::min(kChunk, count - first);
    for (Index c = 0; c < width; ++c) {
      const double* from = components[static_cast<std::size_t>(c)] + first;
      Real* to = chunk.data() + c;
      for (Index i = 0; i < size; ++i) to[i * width] = static_cast<Real>(from[i]);
    }
    file.write(chunk.data(), static_cast<std::size_t>(size * width) * sizeof(Real));
  }
}

}  // namespace

VtkPolyData::VtkPolyData(ConstVectors points, Index count, bool single_precision)
    : count_(count),
      single_precision_(single_precision),
      points_{"points", {points.x, points.y, points.z}, {}} {}

void VtkPolyData::polygons(const Faces& faces) {
  cells_ = "Polys";
  connectivity_ = faces.nodes;
  ends_ = std::span(faces.begin).subspan(1);
}

void VtkPolyData::vertices() {
  cells_ = "Verts";
  numbers_.resize(static_cast<std::size_t>(count_) + 1);
  std::iota(numbers_.begin(), numbers_.end(), 0);
  connectivity_ = std::span(numbers_).first(numbers_.size() - 1);
  ends_ = std::span(numbers_).subspan(1);
}

void VtkPolyData::add(const std::string& name, const double* values) {
  fields_.push_back({name, {values}, {}});
}

void VtkPolyData::add(const std::string& name, ConstVectors vectors) {
  fields_.push_back({name, {vectors.x, vectors.y, vectors.z}, {}});
}

void VtkPolyData::add(const std::string& name, std::vector<const double*> components,
                      std::vector<std::string> component_names) {
  fields_.push_back({name, std::move(components), std::move(component_names)});
}

std::uint64_t VtkPolyData::bytes(const Array& array) const {
  return static_cast<std::uint64_t>(count_) * array.components.size() *
         (single_precision_ ? sizeof(float) : sizeof(double));
}

std::string VtkPolyData::header() const {
  Header h;
  const auto real_array = [&](const Array& a) {
    std::string attributes = quoted("Name", a.name);
    const auto attribute = [&](const std::string& key, const std::string& value) {
      attributes.append(" ").append(quoted(key, value));
    };
    attribute("NumberOfComponents", std::to_string(a.components.size()));
    for (std::size_t c = 0; c < a.component_names.size(); ++c)
      attribute("ComponentName" + std::to_string(c), a.component_names[c]);
    h.array(single_precision_ ? "Float32" : "Float64", attributes, bytes(a));
  };
  h.text(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n");
  h.array("Float64", R"(Name="TimeValue" NumberOfTuples="1")", sizeof(double));
  h.text("</FieldData>\n<Piece ").text(quoted("NumberOfPoints", std::to_string(count_))).text(" ");
  h.text(quoted(std::string("NumberOf") + cells_, std::to_string(ends_.size()))).text(">\n");
  h.text("<Points>\n");
  real_array(points_);
  h.text("</Points>\n<PointData>\n");
  for (const Array& field : fields_) real_array(field);
  h.text("</PointData>\n<").text(cells_).text(">\n");
  h.array("Int32", quoted("Name", "connectivity"), connectivity_.size_bytes());
  h.array("Int32", quoted("Name", "offsets"), ends_.size_bytes());
  h.text("</").text(cells_).text(">\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
  return h.text();
}

void VtkPolyData::write(const std::filesystem::path& path, double time) const {
  OutputFile file(path);
  file.write(header());
  write_array(file, &time, sizeof(time));
  const auto write_reals = [&](const Array& a) {
    const std::uint64_t length = bytes(a);
    file.write(&length, sizeof(length));
    if (single_precision_)
      write_interleaved<float>(file, a.components, count_);
    else
      write_interleaved<double>(file, a.components, count_);
  };
  write_reals(points_);
  for (const Array& field : fields_) write_reals(field);
  write_array(file, connectivity_.data(), connectivity_.size_bytes());
  write_array(file, ends_.data(), ends_.size_bytes());
  file.write("\n</AppendedData>\n</VTKFile>\n");
  file.commit();
}

}  // namespace deform::outputs
