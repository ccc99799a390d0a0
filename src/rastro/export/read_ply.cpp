// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/ply.h"

namespace rastro {
namespace {

constexpr std::uint64_t most_elements = 1ULL << 31;

struct Property {
  std::string name;
  char kind = 'f';  ///< 'i' signed, 'u' unsigned, 'f' floating.
  int bytes = 4;
  bool is_list = false;
  char count_kind = 'u';
  int count_bytes = 1;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { text, little, big };

/// Numbers of the body, one after the other, whatever they are written as.
class Body {
 public:
  Body(std::string_view bytes, Encoding encoding, const std::string& where)
      : bytes_(bytes), encoding_(encoding), where_(where) {}

  double number(char kind, int size) {
    if (encoding_ == Encoding::text) return word();
    if (bytes_.size() < static_cast<std::size_t>(size)) refuse("ends early");
    std::uint64_t raw = 0;
    for (int k = 0; k < size; ++k) {
      const int at = encoding_ == Encoding::little ? k : size - 1 - k;
      raw |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[static_cast<std::size_t>(at)])) << (8 * k);
    }
    bytes_.remove_prefix(static_cast<std::size_t>(size));
    return value_of(raw, kind, size);
  }

  std::size_t size() const { return bytes_.size(); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(what, where_, "give a PLY file, such as 'rastro export --to ply' writes");
  }

 private:
  static double value_of(std::uint64_t raw, char kind, int size) {
    if (kind == 'f')
      return size == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)))
                       : std::bit_cast<double>(raw);
    if (kind == 'u') return static_cast<double>(raw);
    const int unused_bits = 64 - 8 * size;
    return static_cast<double>(static_cast<std::int64_t>(raw << unused_bits) >> unused_bits);
  }

  double word() {
    const std::size_t begin = bytes_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) refuse("ends early");
    bytes_.remove_prefix(begin);
    const std::size_t length = std::min(bytes_.find_first_of(" \t\r\n"), bytes_.size());
    const auto value = parse_double(bytes_.substr(0, length));
    if (!value) refuse(in_quotes(bytes_.substr(0, length)) + " is not a number");
    bytes_.remove_prefix(length);
    return *value;
  }

  std::string_view bytes_;
  Encoding encoding_;
  const std::string& where_;
};

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& where) : where_(where) { read_head(bytes); }

  TriangleMesh mesh_and_cloud(PointCloud& cloud) {
    Body body(body_, encoding_, where_);
    TriangleMesh mesh;
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        read_vertices(element, body, cloud);
      } else if (element.name == "face") {
        read_faces(element, body, mesh);
      } else {
        for (std::uint64_t k = 0; k < element.count; ++k) skip(element, body);
      }
    }
    check_faces(mesh, cloud.points.size());
    return mesh;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { Body({}, Encoding::text, where_).refuse(what); }

  void read_head(std::string_view bytes) {
    if (!bytes.starts_with("ply\n") && !bytes.starts_with("ply\r\n")) refuse("is not a PLY file");
    bool ended = false;
    while (!ended) {
      const std::size_t end = bytes.find('\n');
      if (end == std::string_view::npos) refuse("has no end_header");
      const auto words = split_words(trim(bytes.substr(0, end)));
      bytes.remove_prefix(end + 1);
      ended = !words.empty() && words[0] == "end_header";
      if (!words.empty() && !ended) read_head_line(words);
    }
    body_ = bytes;
  }

  void read_head_line(std::span<const std::string_view> words) {
    if (words[0] == "format") {
      if (words.size() < 2) refuse("has an unknown format");
      if (words[1] == "ascii") {
        encoding_ = Encoding::text;
      } else if (words[1] == "binary_little_endian" || words[1] == "binary_big_endian") {
        encoding_ = words[1] == "binary_big_endian" ? Encoding::big : Encoding::little;
      } else {
        refuse("has an unknown format");
      }
    } else if (words[0] == "element") {
      const auto count = words.size() == 3 ? parse_uint64(words[2]) : std::nullopt;
      if (!count || *count > most_elements) refuse("has an element without a valid count");
      elements_.push_back({std::string(words[1]), *count, {}});
    } else if (words[0] == "property") {
      add_property(words);
    }
  }

  void add_property(std::span<const std::string_view> words) {
    if (elements_.empty()) refuse("has a property of nothing");
    Property property;
    property.is_list = words.size() == 5 && words[1] == "list";
    if (words.size() != 3 && !property.is_list) refuse("has an unknown property");
    property.name = words.back();
    set_type(words[words.size() - 2], property.kind, property.bytes);
    if (property.is_list) set_type(words[2], property.count_kind, property.count_bytes);
    elements_.back().properties.push_back(property);
  }

  void set_type(std::string_view name, char& kind, int& bytes) const {
    struct Type {
      std::string_view name;
      char kind;
      int bytes;
    };
    static constexpr std::array<Type, 16> types{{{"char", 'i', 1},
                                                 {"int8", 'i', 1},
                                                 {"uchar", 'u', 1},
                                                 {"uint8", 'u', 1},
                                                 {"short", 'i', 2},
                                                 {"int16", 'i', 2},
                                                 {"ushort", 'u', 2},
                                                 {"uint16", 'u', 2},
                                                 {"int", 'i', 4},
                                                 {"int32", 'i', 4},
                                                 {"uint", 'u', 4},
                                                 {"uint32", 'u', 4},
                                                 {"float", 'f', 4},
                                                 {"float32", 'f', 4},
                                                 {"double", 'f', 8},
                                                 {"float64", 'f', 8}}};
    const auto found = std::find_if(types.begin(), types.end(), [&](const Type& type) { return type.name == name; });
    if (found == types.end()) refuse(in_quotes(name) + " is not a property type");
    kind = found->kind, bytes = found->bytes;
  }

  static void skip_list(const Property& property, Body& body) {
    const double count = body.number(property.count_kind, property.count_bytes);
    for (double k = 0; k < count; ++k) body.number(property.kind, property.bytes);
  }

  void skip(const Element& element, Body& body) const {
    for (const Property& property : element.properties) {
      if (property.is_list) {
        skip_list(property, body);
      } else {
        body.number(property.kind, property.bytes);
      }
    }
  }

  /// Where a number goes; -1: nowhere.
  static int role_of(const std::string& name) {
    static constexpr std::array<std::string_view, 11> names{"x",   "y",     "z",    "nx",    "ny",   "nz",
                                                            "red", "green", "blue", "count", "sigma"};
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }

  void read_vertices(const Element& element, Body& body, PointCloud& cloud) {
    std::vector<int> roles;
    for (const Property& property : element.properties) roles.push_back(role_of(property.name));
    for (const int needed : {0, 1, 2})
      if (std::find(roles.begin(), roles.end(), needed) == roles.end()) refuse("has vertices without x, y, z");
    cloud.points.reserve(std::min<std::uint64_t>(element.count, body.size()));  // each takes bytes
    for (std::uint64_t k = 0; k < element.count; ++k) {
      std::array<double, 11> values{};
      for (std::size_t p = 0; p < roles.size(); ++p) {
        const Property& property = element.properties[p];
        if (property.is_list) {
          skip_list(property, body);
          continue;
        }
        double value = body.number(property.kind, property.bytes);
        const bool shade = roles[p] >= 6 && roles[p] <= 8 && property.kind == 'f';
        if (roles[p] >= 0) values[static_cast<std::size_t>(roles[p])] = shade ? 255.0 * value : value;
      }
      cloud.points.push_back(point_of(values));
    }
  }

  static CloudPoint point_of(const std::array<double, 11>& values) {
    const auto whole = [](double value, double most) {
      return value > 0.0 ? static_cast<std::uint32_t>(std::lround(std::min(value, most))) : 0U;
    };
    CloudPoint point;
    point.position = Eigen::Vector3d(values[0], values[1], values[2]).cast<float>();
    point.normal = Eigen::Vector3d(values[3], values[4], values[5]).cast<float>();
    for (std::size_t k = 0; k < 3; ++k) point.color[k] = static_cast<std::uint8_t>(whole(values[6 + k], 255.0));
    point.count = whole(values[9], 4e9);
    point.sigma = std::isfinite(values[10]) ? static_cast<float>(values[10]) : 0.0F;
    return point;
  }

  void read_faces(const Element& element, Body& body, TriangleMesh& mesh) {
    for (std::uint64_t k = 0; k < element.count; ++k) {
      for (const Property& property : element.properties) {
        if (!property.is_list) {
          body.number(property.kind, property.bytes);
        } else if (property.name == "vertex_indices" || property.name == "vertex_index") {
          read_polygon(property, body, mesh);
        } else {
          skip_list(property, body);
        }
      }
    }
  }

  void read_polygon(const Property& property, Body& body, TriangleMesh& mesh) const {
    const double vertex_count = body.number(property.count_kind, property.count_bytes);
    std::uint32_t first = 0, last = 0;
    for (double k = 0; k < vertex_count; ++k) {
      const double value = body.number(property.kind, property.bytes);
      if (!(value >= 0.0 && value < static_cast<double>(most_elements))) refuse("has a face with invalid vertices");
      const auto vertex = static_cast<std::uint32_t>(value);
      if (k == 0) first = vertex;
      if (k >= 2) mesh.triangles.push_back({first, last, vertex});
      last = vertex;
    }
  }

  void check_faces(const TriangleMesh& mesh, std::size_t vertices) const {
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t vertex : triangle)
        if (vertex >= vertices) refuse("has a face with a missing vertex");
  }

  const std::string& where_;
  Encoding encoding_ = Encoding::text;
  std::vector<Element> elements_;
  std::string_view body_;
};

}  // namespace

PointCloud parse_cloud_ply(std::string_view bytes, const std::string& where) {
  PointCloud cloud;
  Reader(bytes, where).mesh_and_cloud(cloud);
  std::erase_if(cloud.points, [](const CloudPoint& point) { return !point.position.allFinite(); });
  // Other programs write nan where a point has no normal.
  for (CloudPoint& point : cloud.points)
    if (!point.normal.allFinite()) point.normal.setZero();
  return cloud;
}

TriangleMesh parse_mesh_ply(std::string_view bytes, const std::string& where) {
  PointCloud cloud;
  TriangleMesh mesh = Reader(bytes, where).mesh_and_cloud(cloud);
  for (const CloudPoint& point : cloud.points) mesh.vertices.push_back({point.position, point.normal, point.color});
  std::erase_if(mesh.triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
    return std::any_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t vertex) { return !mesh.vertices[vertex].position.allFinite(); });
  });
  return mesh;
}

PointCloud read_cloud_ply(const std::string& file) { return parse_cloud_ply(read_whole_file(file), file); }
TriangleMesh read_mesh_ply(const std::string& file) { return parse_mesh_ply(read_whole_file(file), file); }

}  // namespace rastro
