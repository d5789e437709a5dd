#pragma once

#include <dragcore/bake.hpp>
#include <filesystem>
#include <string>

/// Baked bodies in files. Part of dragcore::field_files, for it needs HDF5, whose C library is not safe for threads: read and write from
/// one thread at a time.
namespace dragcore {

/// HDF5: root attributes `schema` = "dragcore.baked_body", `schema_version` = "1.0", `model` (law and pillow with their numbers),
/// `surface_hash` and `model_hash` (hexadecimal: BakedBody::matches() says whether the map is stale); datasets `steady` [n, n, 1, 8], and
/// where spin was baked `rate` [n, n, 3, 8] and `tumble` [n, n, 4, 8], float; `centre` [3], `area`, `length`, `rms_force` [1], `error` [4],
/// `spin_ratios` [3] and `spin_error` [3, 4], double. Each has attributes `units`, `frame` and `long_name`; BakedBody says what they mean.
/// @throws std::runtime_error  file missing, truncated, not HDF5, without checksums or of another schema; wrong shapes, units or types;
/// values
///                             that are not finite: file and fault
BakedBody read_baked(const std::filesystem::path& file);

/// Writes under a temporary name beside it and renames. @throws std::runtime_error when the file cannot be written
void write_baked(const std::filesystem::path& file, const BakedBody& body);

/// The maps as arrays in a C99 header that needs <math.h> alone, and a function that evaluates them as wrench() does, for programs without
/// dragcore: `name`_wrench(flow, spin, density, force, torque), torque about the map's centre. To be included by one file.
/// @param name  that of the function: letters, digits and underscores
/// @throws std::invalid_argument  a name that C does not take. std::runtime_error when the file cannot be written
void write_c_header(const std::filesystem::path& file, const BakedBody& body, const std::string& name);

}  // namespace dragcore
