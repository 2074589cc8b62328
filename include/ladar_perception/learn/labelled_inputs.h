// SPDX-License-Identifier: BSD-3-Clause
// What to learn from and to be judged on: files of labelled clouds, folders of them, and bags.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/io/scan_file.h"

namespace ladar_perception {

/// How a labelled cloud goes through the pipeline.
enum class Pass {
  kWhole,     ///< in one scan, into a map that holds all of it
  kStream,    ///< as the scans of a vehicle that drives through it, into the vehicle's map
  kRecorded,  ///< a bag: its scans as they were recorded, into the vehicle's map
};
const char* passName(Pass pass);
/// Throws std::runtime_error that lists the names if it is neither "whole" nor "stream".
Pass passFromName(const std::string& name);

struct LabelledFile {
  std::string path;
  std::optional<ScanFormat> format;  ///< none: a bag
};

/// One argument of the command line: a file, or a folder with its files.
struct LabelledInput {
  std::string name;
  std::vector<LabelledFile> files;
};

/// Inputs by the extensions of their files (.xyz_label_conf .bin .pcd .ply .xyz .csv .vtk .3d
/// .bag); `format_name` (of scanFormatNames(), or "bag") tells it for all inputs whatever they are
/// called,
/// "" does not. Throws std::runtime_error that names the input: it does not exist, its extension is
/// unknown, or a folder has no such files or files of several formats.
std::vector<LabelledInput> listLabelledInputs(const std::vector<std::string>& arguments,
                                              const std::string& format_name);

/// The passes for a file: as recorded for a bag; else `wanted`, or, if there are none, both for
/// formats of surveyed tiles (oakland), and `whole` for others, which are single scans.
std::vector<Pass> passesOf(const LabelledFile& file, const std::vector<Pass>& wanted);

}  // namespace ladar_perception
