// SPDX-License-Identifier: BSD-3-Clause
// Writes scans with all their fields.
#pragma once

#include <ostream>
#include <string>

#include "ladar_perception/io/scan.h"
#include "ladar_perception/io/scan_file.h"

namespace ladar_perception {

/// Writes a scan in the byte order of the machine, without padding:
/// - kPcd: binary, every field as it is;
/// - kPly: binary; rgb becomes red green blue, normal_x normal_y normal_z become nx ny nz, as other
///   programs expect; a field of several scalars becomes name_0 name_1 ...;
/// - kXyz: a line of names, then a line a point, with as many digits as it takes to read the same
///   numbers again; names as in kPly but for the normals.
/// Throws std::runtime_error for other formats and for fields that are not in the machine's byte
/// order. Check the stream afterwards.
void writeScan(const Scan& scan, ScanFormat format, std::ostream* stream);

/// The format of a file to write by its name, .pcd, .ply, .xyz, .txt or .csv (with blanks between
/// the columns all the same). Throws std::runtime_error that lists them.
ScanFormat writtenFormat(const std::string& path);

/// Whether a field holds a colour as bits 0x00RRGGBB: one 4-byte scalar named rgb or rgba.
bool isPackedColor(const Field& field);

}  // namespace ladar_perception
