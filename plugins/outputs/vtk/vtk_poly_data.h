/// VTK's XML PolyData format (.vtp): points, polygons or vertices, and fields at the points.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <deform/surface/surface.h>

namespace deform::outputs {

/// One data set. Arrays are only referred to: they must live until write(). Data follow the XML
/// text as raw little-endian bytes ("appended"), each array after its length as UInt64.
class VtkPolyData {
 public:
  /// `single_precision`: Float32 instead of Float64 for points and fields.
  VtkPolyData(ConstVectors points, Index count, bool single_precision);

  void polygons(const Faces& faces);
  /// One vertex a point, for clouds of samples.
  void vertices();
  /// Fields: a number, a vector, or named components, a point.
  void add(const std::string& name, const double* values);
  void add(const std::string& name, ConstVectors vectors);
  void add(const std::string& name, std::vector<const double*> components,
           std::vector<std::string> component_names);

  /// Writes the file (see OutputFile); `time` [s] becomes its TimeValue.
  void write(const std::filesystem::path& path, double time) const;

 private:
  struct Array {
    std::string name;
    std::vector<const double*> components;
    std::vector<std::string> component_names;
  };
  [[nodiscard]] std::string header() const;
  [[nodiscard]] std::uint64_t bytes(const Array& array) const;

  Index count_;
  bool single_precision_;
  Array points_;
  std::vector<Array> fields_;
  const char* cells_ = "Polys";
  std::span<const std::int32_t> connectivity_, ends_;
  std::vector<std::int32_t> numbers_;  // 0 … count: the vertices' connectivity and ends
};

}  // namespace deform::outputs
