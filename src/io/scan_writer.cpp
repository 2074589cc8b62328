// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/scan_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace ladar_perception {
namespace {

/// A scalar as it is written: some bytes of a point.
struct Item {
  std::string name;
  ScalarType type;
  uint32_t offset;  ///< from the start of a point
};

const uint8_t* pointAt(const Scan& scan, std::size_t i) {
  const CloudLayout& layout = scan.layout;
  return CloudView{layout, scan.data.data(), scan.data.size()}.point(i / layout.width,
                                                                     i % layout.width);
}

/// Names end at blanks and commas in all formats.
std::string oneWord(std::string name) {
  const auto separates = [](char c) { return c == ' ' || c == '\t' || c == ',' || c == ';'; };
  std::replace_if(name.begin(), name.end(), separates, '_');
  return name;
}

/// Scalars one by one, colours in their three parts.
std::vector<Item> itemsOf(const CloudLayout& layout) {
  std::vector<Item> items;
  for (const Field& field : layout.fields) {
    if (isPackedColor(field)) {
      constexpr std::array<const char*, 3> kParts = {"red", "green", "blue"};
      // The lowest byte is blue; an alpha, the highest, goes away.
      for (uint32_t i = 0; i < 3; ++i) {
        items.push_back({kParts[i], ScalarType::kUint8, field.offset + 2 - i});
      }
      continue;
    }
    const auto size = static_cast<uint32_t>(scalarSize(field.type));
    for (uint32_t i = 0; i < std::max(field.count, 1U); ++i) {
      const std::string suffix = field.count > 1 ? "_" + std::to_string(i) : "";
      items.push_back({oneWord(field.name) + suffix, field.type, field.offset + i * size});
    }
  }
  return items;
}

/// PCD's letter for a type.
char pcdType(ScalarType type) {
  if (type == ScalarType::kFloat32 || type == ScalarType::kFloat64) return 'F';
  const bool has_sign =
      type == ScalarType::kInt8 || type == ScalarType::kInt16 || type == ScalarType::kInt32;
  return has_sign ? 'I' : 'U';
}

void writePcd(const Scan& scan, std::ostream& out) {
  std::string names;
  std::string sizes;
  std::string types;
  std::string counts;
  for (const Field& field : scan.layout.fields) {
    names += " " + oneWord(field.name);
    sizes += " " + std::to_string(scalarSize(field.type));
    types += std::string(" ") + pcdType(field.type);
    counts += " " + std::to_string(std::max(field.count, 1U));
  }
  out << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" << names << "\nSIZE"
      << sizes << "\nTYPE" << types << "\nCOUNT" << counts << "\nWIDTH " << scan.layout.width
      << "\nHEIGHT " << scan.layout.height << "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << scan.size()
      << "\nDATA binary\n";
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const auto* point = reinterpret_cast<const char*>(pointAt(scan, i));
    for (const Field& field : scan.layout.fields) {
      const std::size_t bytes = scalarSize(field.type) * std::max(field.count, 1U);
      out.write(point + field.offset, static_cast<std::streamsize>(bytes));
    }
  }
}

std::string plyName(const std::string& name) {
  const bool is_normal = name == "normal_x" || name == "normal_y" || name == "normal_z";
  return is_normal ? std::string("n") + name.back() : name;
}

const char* plyType(ScalarType type) {
  constexpr std::array<const char*, 8> kNames = {"char", "uchar", "short", "ushort",
                                                 "int",  "uint",  "float", "double"};
  return kNames[static_cast<std::size_t>(type) - 1];
}

void writePly(const Scan& scan, std::ostream& out) {
  const std::vector<Item> items = itemsOf(scan.layout);
  constexpr bool kBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
  out << "ply\nformat binary_" << (kBigEndian ? "big" : "little") << "_endian 1.0\nelement vertex "
      << scan.size() << "\n";
  for (const Item& item : items) {
    out << "property " << plyType(item.type) << " " << plyName(item.name) << "\n";
  }
  out << "end_header\n";
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const auto* point = reinterpret_cast<const char*>(pointAt(scan, i));
    for (const Item& item : items) {
      out.write(point + item.offset, static_cast<std::streamsize>(scalarSize(item.type)));
    }
  }
}

template <typename T>
void appendAs(const uint8_t* bytes, std::string* line) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  line->append(text.data(), result.ptr);
}

void appendScalar(const uint8_t* bytes, ScalarType type, std::string* line) {
  switch (type) {
    case ScalarType::kInt8:
      return appendAs<int8_t>(bytes, line);
    case ScalarType::kUint8:
      return appendAs<uint8_t>(bytes, line);
    case ScalarType::kInt16:
      return appendAs<int16_t>(bytes, line);
    case ScalarType::kUint16:
      return appendAs<uint16_t>(bytes, line);
    case ScalarType::kInt32:
      return appendAs<int32_t>(bytes, line);
    case ScalarType::kUint32:
      return appendAs<uint32_t>(bytes, line);
    case ScalarType::kFloat32:
      return appendAs<float>(bytes, line);
    case ScalarType::kFloat64:
      return appendAs<double>(bytes, line);
  }
}

void writeText(const Scan& scan, std::ostream& out) {
  const std::vector<Item> items = itemsOf(scan.layout);
  std::string line;
  for (const Item& item : items) line += (line.empty() ? "" : " ") + item.name;
  out << line << "\n";
  for (std::size_t i = 0; i < scan.size(); ++i) {
    line.clear();
    const uint8_t* point = pointAt(scan, i);
    for (const Item& item : items) {
      if (!line.empty()) line += ' ';
      appendScalar(point + item.offset, item.type, &line);
    }
    line += '\n';
    out << line;
  }
}

}  // namespace

bool isPackedColor(const Field& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.count <= 1 &&
         scalarSize(field.type) == 4;
}

void writeScan(const Scan& scan, ScanFormat format, std::ostream* stream) {
  if (scan.layout.big_endian) throw std::runtime_error("a big-endian scan cannot be written");
  if (format == ScanFormat::kPcd) {
    writePcd(scan, *stream);
  } else if (format == ScanFormat::kPly) {
    writePly(scan, *stream);
  } else if (format == ScanFormat::kXyz) {
    writeText(scan, *stream);
  } else {
    throw std::runtime_error("format " + scanFormatNames()[static_cast<std::size_t>(format)] +
                             " can be read only, expected pcd, ply or xyz");
  }
}

ScanFormat writtenFormat(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".pcd") return ScanFormat::kPcd;
  if (extension == ".ply") return ScanFormat::kPly;
  if (extension == ".xyz" || extension == ".txt" || extension == ".csv") return ScanFormat::kXyz;
  throw std::runtime_error(path + ": extension '" + extension +
                           "' names no format to write, expected .pcd, .ply, .xyz, .txt or .csv");
}

}  // namespace ladar_perception
