// SPDX-License-Identifier: BSD-3-Clause
// One name per file format, one function that reads any of them.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

enum class ScanFormat { kOakland, kKitti, kPcd, kPly, kXyz, kVtk, k3dtk };

/// "oakland", "kitti", "pcd", "ply", "xyz", "vtk", "3dtk", in the order of the enumerators.
const std::vector<std::string>& scanFormatNames();
/// Throws std::runtime_error that lists the names if it is none of them.
ScanFormat scanFormatFromName(const std::string& name);

/// The format of a file by its extension. Throws std::runtime_error that lists those known.
ScanFormat scanFormatFromPath(const std::string& path);

/// Reads a file; `columns` names the columns of kXyz (see readTextScan) and is not for others.
Scan readScan(const std::string& path, ScanFormat format,
              const std::vector<std::string>& columns = {});

/// Files in the order given; a folder stands for its files with the extension of the format (for
/// kXyz .xyz, else .csv, else .txt), sorted by name with numbers by value (scan2 before scan10).
/// Throws std::runtime_error if an input does
/// not exist or a folder has no such file.
std::vector<std::string> listScanFiles(const std::vector<std::string>& inputs, ScanFormat format);

}  // namespace ladar_perception
