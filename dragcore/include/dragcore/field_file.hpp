#pragma once

#include <dragcore/wind.hpp>
#include <filesystem>
#include <string>
#include <vector>

/// Wind fields in files. Part of dragcore::field_files. HDF5's C library is not safe for threads: read and write HDF5 from one thread at a
/// time.
namespace dragcore {

/// Where an FGA file's vectors lie in its bounds: the outermost on them, as the note samples, or each in the middle of its cell, as texture
/// hardware does.
enum class FgaPoints { on_bounds, cell_centres };

/// Along which axis an FGA file's vectors follow each other: x, as Unreal's importer reads them, or z, as Unreal 5's own exporter writes
/// them. The two agree on fields of one point along two of the axes only.
enum class FgaOrder { x_fastest, z_fastest };

/// What an FGA file does not say. The engine that made the format popular uses centimetres and a left-handed frame: length_m = 0.01, and
/// Placement::scale (1, -1, 1).
struct FgaMeaning {
  double length_m = 1.0;   ///< size of the file's unit of length [m]
  double speed_m_s = 1.0;  ///< size of the file's unit of velocity [m/s]
  FgaPoints points = FgaPoints::on_bounds;
  FgaOrder order = FgaOrder::x_fastest;
  Outside outside = Outside::zero;
  /// Of a flat field, along an axis of one point whose bounds are equal: half of it to either side [m]. 0: as much as its widest cell.
  double thickness_m = 0.0;
};

/// Reads a text of comma- or space-separated numbers: points per axis, lower bounds, upper bounds, then one vector per point.
/// @throws std::runtime_error  missing file, a word that is not a finite number, counts that do not fit the vectors found, empty bounds:
/// file, place and fault
GridField read_fga(const std::filesystem::path& file, const FgaMeaning& meaning = {});

/// One vector per line, shortest decimal form that reads back to the same bits.
/// @return  what the file's users should know, a sentence each: more than 128 points along an axis, which Unreal does not take
/// @throws std::runtime_error  when the file cannot be written
std::vector<std::string> write_fga(const std::filesystem::path& file, const GridField& field, const FgaMeaning& meaning = {});

/// HDF5: root attributes `schema` = "dragcore.wind_field", `schema_version` = "1.0", `outside` = "zero" or "clamp"; datasets `velocity`
/// [nz, ny, nx, 3] in m/s, `lower` and `upper` [3] in m, each with attributes `units`, `frame` (the field's own) and `long_name`.
/// Only files with checksums on their structure and texts of fixed length are read, as write_field_hdf5() and h5py with libver='v110' and
/// numpy.bytes_ make them: others can bring HDF5 1.10 down when they are damaged.
/// @throws std::runtime_error  file missing, truncated, not HDF5, without checksums or of another schema, wrong shapes, units or types,
/// values that are not finite: file and fault
GridField read_field_hdf5(const std::filesystem::path& file);

/// Writes under a temporary name beside it and renames. @throws std::runtime_error when the file cannot be written
void write_field_hdf5(const std::filesystem::path& file, const GridField& field);

}  // namespace dragcore
