// SPDX-License-Identifier: BSD-3-Clause
// Readers of point clouds in text files. All throw std::runtime_error that names file, line, the
// token found and what was expected. Lines that start with '#' or "//" and blank lines are skipped;
// cells are separated by commas, semicolons, blanks or tabs; line ends may be CRLF; a cell may be
// nan; in files with commas an empty cell is NaN.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// `x y z [more]` in metres (.xyz, .txt, .csv). `columns` names the columns in order and "_" skips
/// one; without it a header line names them, else they are x y z c3 c4 ... Coordinates are
/// float32 unless that would cost more than a millimetre.
Scan readTextScan(const std::string& path, const std::vector<std::string>& columns = {});

/// `x y z label confidence` of the Oakland 3-D set (.xyz_label_conf); label becomes uint16.
Scan readOaklandScan(const std::string& path);

/// 3DTK .3d: `x y z [more]` in centimetres, left-handed (x right, y up, z forward), turned into
/// metres, x forward, y left, z up.
Scan read3dtkScan(const std::string& path);

/// VTK legacy ASCII polydata: the points and the scalars, vectors and normals given for them.
Scan readVtkScan(const std::string& path);

}  // namespace ladar_perception
