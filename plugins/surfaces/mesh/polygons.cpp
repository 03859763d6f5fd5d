#include "polygons.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <string_view>
#include <tiny_obj_loader.h>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <deform/error.h>

namespace mesh {
namespace {

namespace fs = std::filesystem;
using deform::InputError;

[[noreturn]] void reject(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

/// Numbers of names, in the order in which they come.
class Names {
 public:
  explicit Names(std::vector<std::string>& all) : all_(&all) {}
  std::int32_t number(const std::string& name) {
    if (name.empty()) return -1;
    const auto [at, is_new] = numbers_.emplace(name, static_cast<std::int32_t>(all_->size()));
    if (is_new) all_->push_back(name);
    return at->second;
  }

 private:
  std::vector<std::string>* all_;
  std::map<std::string, std::int32_t> numbers_;
};

/// Whether text starts with a number of that type, and has nothing behind it before `stop`.
template <class Number>
bool is_number(std::string_view text, Number& value, char stop = '\0') {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() &&
         (end == text.data() + text.size() || (stop != '\0' && *end == stop));
}

/// Throws where a line of vertices or polygons is not of numbers: the reader takes them for 0.
void check_lines(const fs::path& file) {
  std::ifstream lines(file, std::ios::binary);
  std::string line, word;
  for (std::int64_t number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    if (!(words >> word) || (word != "v" && word != "f")) continue;
    const bool is_vertex = word == "v";
    int count = 0;
    bool is_sound = true;
    while (is_sound && (!is_vertex || count < 3) && words >> word && !word.starts_with('#')) {
      double x = 0;
      std::int32_t a = 0;
      is_sound = is_vertex ? is_number(word, x) && std::isfinite(x) : is_number(word, a, '/');
      ++count;
    }
    if (!is_sound || count < 3)
      reject(file,
             "line " + std::to_string(number) + " (\"" + line.substr(0, 60) + "\"): expected " +
                 (is_vertex ? "v and three finite numbers" : "f and three vertices at least"));
  }
}

Polygons read_obj(const fs::path& file) {
  check_lines(file);
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;
  config.vertex_color = false;
  tinyobj::ObjReader reader;
  if (!reader.ParseFromFile(file.string(), config) || !reader.Error().empty())
    reject(file, reader.Error().empty() ? "cannot be read as OBJ" : reader.Error());
  Polygons polygons;
  const std::vector<double>& xyz = reader.GetAttrib().vertices;
  const auto vertices = static_cast<Index>(xyz.size() / 3);
  polygons.positions.resize(vertices, 3);
  for (Index a = 0; a < vertices; ++a)
    for (Index c = 0; c < 3; ++c)
      polygons.positions(a, c) = xyz[static_cast<std::size_t>(3 * a + c)];
  Names groups(polygons.group_names);
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    std::size_t at = 0;
    for (const auto corners : shape.mesh.num_face_vertices) {
      for (std::size_t k = 0; k < corners; ++k)
        polygons.faces.nodes.push_back(shape.mesh.indices[at++].vertex_index);
      polygons.faces.begin.push_back(static_cast<std::int32_t>(polygons.faces.nodes.size()));
      polygons.group.push_back(groups.number(shape.name));
    }
  }
  return polygons;
}

/// Whether a PLY file has a whole header; its reader looks for the end of it for ever.
bool has_header(const fs::path& file) {
  constexpr int kMostLines = 10000;
  std::ifstream lines(file, std::ios::binary);
  std::string line;
  for (int i = 0; i < kMostLines && std::getline(lines, line); ++i)
    if (line.starts_with("end_header")) return true;
  return false;
}

Polygons read_by_assimp(const fs::path& file) {
  Assimp::Importer importer;
  const aiScene* const scene =
      importer.ReadFile(file.string(), aiProcess_PreTransformVertices | aiProcess_DropNormals);
  if (scene == nullptr) reject(file, importer.GetErrorString());
  Polygons polygons;
  Names groups(polygons.group_names);
  Index vertices = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) vertices += scene->mMeshes[m]->mNumVertices;
  polygons.positions.resize(vertices, 3);
  Index first = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    for (unsigned a = 0; a < part.mNumVertices; ++a)
      polygons.positions.row(first + a) << part.mVertices[a].x, part.mVertices[a].y,
          part.mVertices[a].z;
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices < 3) continue;  // points and lines
      for (unsigned k = 0; k < face.mNumIndices; ++k)
        polygons.faces.nodes.push_back(static_cast<std::int32_t>(first + face.mIndices[k]));
      polygons.faces.begin.push_back(static_cast<std::int32_t>(polygons.faces.nodes.size()));
      polygons.group.push_back(groups.number(part.mName.C_Str()));
    }
    first += part.mNumVertices;
  }
  return polygons;
}

}  // namespace

Index weld(Polygons& polygons) {
  const Index vertices = polygons.positions.rows();
  std::vector<Index> order(static_cast<std::size_t>(vertices));
  std::iota(order.begin(), order.end(), Index{0});
  const auto place = [&](Index a) {
    return std::array{polygons.positions(a, 0), polygons.positions(a, 1), polygons.positions(a, 2)};
  };
  std::ranges::stable_sort(order, {}, place);
  std::vector<Index> first(static_cast<std::size_t>(vertices));  // at the same place
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && place(order[i]) == place(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        is_same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  std::vector<std::int32_t> number(static_cast<std::size_t>(vertices));
  Index kept = 0;
  for (Index a = 0; a < vertices; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (first[i] != a) {
      number[i] = number[static_cast<std::size_t>(first[i])];
      continue;
    }
    polygons.positions.row(kept) = polygons.positions.row(a).eval();
    number[i] = static_cast<std::int32_t>(kept++);
  }
  polygons.positions.conservativeResize(kept, 3);
  for (std::int32_t& node : polygons.faces.nodes)
    if (node >= 0 && node < vertices) node = number[static_cast<std::size_t>(node)];
  return vertices - kept;
}

Polygons read_polygons(const fs::path& file) {
  std::error_code none;
  if (!fs::exists(file, none)) reject(file, "there is no such file");
  if (!fs::is_regular_file(file, none)) reject(file, "is no file");
  const std::string ending = ending_of(file);
  if (ending == ".obj") return read_obj(file);
  const bool is_doubled = ending == ".stl" || ending == ".gltf" || ending == ".glb";
  if (!is_doubled && ending != ".ply" && ending != ".off")
    reject(file,
           "ends with \"" + ending + "\", expected a mesh: .obj, .ply, .stl, .off, .gltf or .glb");
  if (ending == ".ply" && !has_header(file)) reject(file, "is no PLY: its header has no end");
  Polygons polygons = read_by_assimp(file);
  if (is_doubled) (void)weld(polygons);
  return polygons;
}

}  // namespace mesh
