#include <hdf5.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/field_file.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string_view>
#include <vector>

#include "tests/support/folder.hpp"

/// HDF5 1.10.8 loses 328 bytes whenever an object's checksum is wrong (its own h5dump too): not ours to report. Read by the leak sanitizer
/// alone.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

using namespace dragcore;
using Catch::Contains;
using Eigen::Vector3d;
using support::Folder;

namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

GridField random_field(const Eigen::Vector3i& points, Outside outside) {
  Grid grid{.points = points,
            .lower = {-1.25, 0.1, 2.0},
            .upper = {2.0, 1.7, 1.0 / 3.0 + 2.0},
            .values = Eigen::Matrix3Xd(3, points.prod()),
            .outside = outside};
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (double& value : grid.values.reshaped()) value = normal(random);
  grid.values(0, 0) = 1e-300;
  return GridField(grid);
}

void check_same(const Grid& a, const Grid& b) {
  CHECK(a.points == b.points);
  CHECK(a.lower == b.lower);
  CHECK(a.upper == b.upper);
  CHECK(a.values == b.values);
  CHECK(a.outside == b.outside);
}

const std::string small_fga = "2, 1, 2,\n-10, -20, -30,\n10, 20, 30,\n1,2,3,\n4,5,6,\n7,8,9,\n-1.5e1,+0,.5,\n";

}  // namespace

TEST_CASE("an FGA file is read as resolution, bounds and vectors, x fastest", "[dragcore][field_file][analytic]") {
  const Folder folder;
  // "+0" is not C++'s idea of a number, but other exporters write it.
  const GridField field = read_fga(folder.write("a.fga", small_fga), {.length_m = 0.01, .speed_m_s = 0.01});
  CHECK(field.grid().points == Eigen::Vector3i(2, 1, 2));
  CHECK((field.grid().lower - Vector3d(-0.1, -0.2, -0.3)).norm() < 1e-16);
  CHECK((field.velocity(Vector3d(0.1, 0.0, -0.3)) - Vector3d(0.04, 0.05, 0.06)).norm() < 1e-16);
  CHECK((field.velocity(Vector3d(-0.1, 0.0, 0.3)) - Vector3d(0.07, 0.08, 0.09)).norm() < 1e-16);
  CHECK((field.velocity(Vector3d(0.1, 0.2, 0.3)) - Vector3d(-0.15, 0.0, 0.005)).norm() < 1e-16);
  // Vectors in the middle of their cells: a quarter of the bounds inside, where an axis has two.
  const GridField centred = read_fga(folder.path / "a.fga", {.points = FgaPoints::cell_centres, .outside = Outside::clamp});
  CHECK(centred.grid().lower == Vector3d(-5.0, -20.0, -15.0));
  CHECK(centred.grid().upper == Vector3d(5.0, 20.0, 15.0));
  CHECK(centred.velocity(Vector3d(-10.0, 0.0, -30.0)) == Vector3d(1, 2, 3));
  // Spaces, tabs, one line, no trailing comma, Windows line ends, a byte-order mark, a resolution written as 2.000: all in use.
  for (const std::string text : {"\xEF\xBB\xBF"
                                 "2.000000,1.0,1\r\n0,0,0\r\n1,1,1\r\n1,2,3\r\n4,5,6",
                                 "2 1 1 0 0 0 1 1 1 1 2 3 4 5 6", "2,1,1,\t0,0,0,1,1,1,1,2,3,4,5,6,"})
    CHECK(read_fga(folder.write("b.fga", text)).velocity(Vector3d(1.0, 0.5, 0.5)) == Vector3d(4, 5, 6));
}

TEST_CASE("an FGA file's vectors follow each other along x or along z, as it is told", "[dragcore][field_file][analytic]") {
  const Folder folder;
  // 2 x 3 x 4 points whose x component numbers the vectors in the order of the file.
  std::string text = "2,3,4,0,0,0,1,2,3";
  for (int i = 0; i < 24; ++i) text += "," + std::to_string(i) + ",0,0";
  const auto file = folder.write("a.fga", text);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 4; ++k) {
        CHECK(read_fga(file).velocity(Vector3d(i, j, k)).x() == (k * 3 + j) * 2 + i);
        CHECK(read_fga(file, {.order = FgaOrder::z_fastest}).velocity(Vector3d(i, j, k)).x() == (i * 3 + j) * 4 + k);
      }
  const GridField field = read_fga(file);
  write_fga(folder.path / "b.fga", field, {.order = FgaOrder::z_fastest});
  check_same(read_fga(folder.path / "b.fga", {.order = FgaOrder::z_fastest}).grid(), field.grid());
  CHECK(read_fga(folder.path / "b.fga").grid().values != field.grid().values);
}

TEST_CASE("a flat FGA field is one cell thick, or as thick as it is told", "[dragcore][field_file][limit]") {
  const Folder folder;
  // 3 x 2 points in the plane z = 5, cells of 2 by 1: the bounds are equal along z.
  const auto file = folder.write("flat.fga", "3,2,1, 0,0,5, 4,1,5, 1,0,0, 2,0,0, 3,0,0, 1,0,0, 2,0,0, 3,0,0");
  const GridField field = read_fga(file);
  CHECK(field.grid().lower == Vector3d(0, 0, 4));
  CHECK(field.grid().upper == Vector3d(4, 1, 6));
  CHECK(field.velocity(Vector3d(2.0, 0.5, 5.9)) == Vector3d(2, 0, 0));
  CHECK(field.velocity(Vector3d(2.0, 0.5, 6.1)) == Vector3d(0, 0, 0));
  const GridField thick = read_fga(file, {.length_m = 0.5, .thickness_m = 10.0});
  CHECK(thick.grid().lower == Vector3d(0, 0, -2.5));
  CHECK(thick.grid().upper == Vector3d(2, 0.5, 7.5));
  // In the middle of cells, three along 4 are 4/3 apart.
  const Grid centred = read_fga(file, {.points = FgaPoints::cell_centres}).grid();
  CHECK_THAT(centred.upper.z() - centred.lower.z(), Catch::Matchers::WithinAbs(4.0 / 3.0, 1e-15));
  // Two axes without size; one that has a size keeps it.
  const Grid line = read_fga(folder.write("line.fga", "1,2,1, 3,0,5, 3,2,5, 1,0,0, 2,0,0"), {.thickness_m = 0.5}).grid();
  CHECK(line.lower == Vector3d(2.75, 0, 4.75));
  CHECK(line.upper == Vector3d(3.25, 2, 5.25));
  CHECK(read_fga(folder.write("slab.fga", "2,2,1, 0,0,0, 1,1,7, 1,0,0, 2,0,0, 1,0,0, 2,0,0")).grid().upper == Vector3d(1, 1, 7));
  // Read, written and read again it is the same.
  write_fga(folder.path / "again.fga", field);
  check_same(read_fga(folder.path / "again.fga").grid(), field.grid());
  CHECK_THROWS_WITH(read_fga(folder.write("point.fga", "1,1,1, 0,0,0, 0,0,0, 1,2,3")), Contains("the field has no size"));
  CHECK(read_fga(folder.path / "point.fga", {.thickness_m = 2.0}).grid().lower == Vector3d(-1, -1, -1));
  CHECK_THROWS_WITH(read_fga(folder.write("two.fga", "2,2,2, 0,0,0, 1,1,0, 1,0,0, 2,0,0, 1,0,0, 2,0,0, 1,0,0, 2,0,0, 1,0,0, 2,0,0")),
                    Contains("upper - lower"));
  CHECK_THROWS_WITH(read_fga(file, {.thickness_m = -1.0}), Contains("thickness_m = -1"));
}

TEST_CASE("who writes an FGA file that is too large for Unreal is told", "[dragcore][field_file]") {
  const Folder folder;
  CHECK(write_fga(folder.path / "a.fga", random_field({128, 1, 2}, Outside::zero)).empty());
  CHECK(write_fga(folder.path / "b.fga", random_field({1, 129, 200}, Outside::zero)) ==
        std::vector<std::string>{"129 points along y: Unreal takes 128 at most. Write fewer if the file is meant for it",
                                 "200 points along z: Unreal takes 128 at most. Write fewer if the file is meant for it"});
  CHECK(read_fga(folder.path / "b.fga").grid().points == Eigen::Vector3i(1, 129, 200));  // written all the same
}

TEST_CASE("wind fields survive a file to the bit", "[dragcore][field_file][invariance]") {
  const Folder folder;
  for (const Eigen::Vector3i& points : {Eigen::Vector3i(1, 1, 1), Eigen::Vector3i(4, 3, 5), Eigen::Vector3i(1, 7, 2)})
    for (const Outside outside : {Outside::zero, Outside::clamp}) {
      const GridField field = random_field(points, outside);
      write_fga(folder.path / "a.fga", field);
      check_same(read_fga(folder.path / "a.fga", {.outside = outside}).grid(), field.grid());
      write_field_hdf5(folder.path / "a.h5", field);
      check_same(read_field_hdf5(folder.path / "a.h5").grid(), field.grid());
      // Through other units and cell centres: rounding of one product.
      const FgaMeaning centimetres{.length_m = 0.01, .speed_m_s = 0.01, .points = FgaPoints::cell_centres, .outside = outside};
      write_fga(folder.path / "b.fga", field, centimetres);
      const Grid back = read_fga(folder.path / "b.fga", centimetres).grid();
      CHECK((back.lower - field.grid().lower).norm() < 1e-14);
      CHECK((back.upper - field.grid().upper).norm() < 1e-14);
      CHECK((back.values - field.grid().values).cwiseAbs().maxCoeff() < 1e-14);
    }
  // The same field, the same bytes; nothing is left beside it.
  const GridField field = random_field({4, 3, 5}, Outside::zero);
  write_field_hdf5(folder.path / "c.h5", field);
  write_field_hdf5(folder.path / "d.h5", field);
  CHECK(contents(folder.path / "c.h5") == contents(folder.path / "d.h5"));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path)) CHECK(entry.path().extension() != ".partial");
}

TEST_CASE("an FGA file that is cut, foreign or wrong gives a message with its fault", "[dragcore][field_file][hard]") {
  const Folder folder;
  const auto refused = [&](const std::string& text, const std::string& what) {
    CHECK_THROWS_WITH(read_fga(folder.write("bad.fga", text)), Contains("bad.fga") && Contains(what));
  };
  // Every cut of a good file. The last vector may lose its separators and, unseen by any reader, digits of its last number: 4 bytes at
  // most.
  for (std::size_t size = 0; size + 4 < small_fga.size(); ++size) {
    INFO(size);
    CHECK_THROWS_AS(read_fga(folder.write("cut.fga", small_fga.substr(0, size))), std::runtime_error);
  }
  refused("", "ends where a number of points is needed");
  refused("2,1,2,-1,-1,-1,1,1,1,1,2,3,4,5,6,7,8,9,10,11", "vector 4 of 4");
  refused(small_fga + "1", "goes on after its last vector");
  refused("2,1,1,0,0,0,1,1,1,1,2,3,4,nan,6", "'nan'");
  refused("2,1,1,0,0,0,1,1,1,1,2,3,4,inf,6", "not a finite number");
  refused("2,1,1,0,0,0,1,1,1,1,2,3,4,1e999,6", "not a finite number");
  refused("2,1,1,0,0,0,1,1,1,1,2,3,4,5x,6", "'5x'");
  refused("2,1,1,0,0,0,1,1,1,1,2,3,4,--5,6", "'--5'");
  refused("0,1,1,0,0,0,1,1,1", "whole number from 1");
  refused("1.5,1,1,0,0,0,1,1,1,1,2,3", "whole number from 1");
  refused("-1,1,1,0,0,0,1,1,1,1,2,3", "whole number from 1");
  refused("1000,1000,1000,0,0,0,1,1,1,1,2,3", "promises 1000 x 1000 x 1000 vectors");
  refused("100000000,100000000,100000000,0,0,0,1,1,1,1,2,3",
          "promises 100000000 x 100000000 x 100000000 vectors");  // more than 64 bits count
  refused("1e300,1e300,1e300,0,0,0,1,1,1,1,2,3", "whole number from 1");
  refused("1,2,1,0,0,0,1,0,1,1,2,3,4,5,6", "upper - lower");
  refused("solid cube", "'solid'");
  refused("1,\x1b[2J\xC3\xA4'\\,1", R"('\x1b[2J\xc3\xa4\'\\' at byte 2)");
  refused("1," + std::string(500, 'x'), "'" + std::string(40, 'x') + "…' at byte 2");
  refused(std::string("\xFF\xFE"
                      "1\0,\0",
                      6),
          "is text in UTF-16");
  refused(std::string("\x89HDF\r\n\x1a\n\0\0", 10), "not a finite number");
  CHECK_THROWS_WITH(read_fga(folder.path / "none.fga"), Contains("no such file"));
  CHECK_THROWS_WITH(read_fga(folder.path), Contains("no such file"));
  CHECK_THROWS_WITH(read_fga(folder.path / "bad.fga", {.length_m = 0.0}), Contains("length_m"));
  CHECK_THROWS_WITH(write_fga(folder.path / "no" / "such" / "folder.fga", random_field({1, 1, 1}, Outside::zero)),
                    Contains("cannot be written"));
}

TEST_CASE("an HDF5 field file that is cut, foreign or wrong gives a message with its fault", "[dragcore][field_file][hard]") {
  const Folder folder;
  const std::filesystem::path good = folder.path / "good.h5", bad = folder.path / "bad.h5";
  write_field_hdf5(good, random_field({4, 3, 5}, Outside::zero));
  const std::string whole = contents(good);
  for (std::size_t size = 0; size < whole.size(); size += size < 600 ? 7 : 61) {
    INFO(size);
    CHECK_THROWS_AS(read_field_hdf5(folder.write("bad.h5", whole.substr(0, size))), std::runtime_error);
  }
  CHECK_THROWS_WITH(read_field_hdf5(folder.write("bad.h5", small_fga)), Contains("bad.h5") && Contains("not an HDF5 file"));
  CHECK_THROWS_WITH(read_field_hdf5(folder.path / "none.h5"), Contains("no such file"));
  CHECK_THROWS_WITH(write_field_hdf5(folder.path / "no" / "such.h5", random_field({1, 1, 1}, Outside::zero)),
                    Contains("cannot be created"));

  // Every change below is made on a copy of the good file, by the library itself.
  const auto refused = [&](const auto& change, const std::string& what) {
    std::filesystem::copy_file(good, bad, std::filesystem::copy_options::overwrite_existing);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    const hid_t file = H5Fopen(bad.c_str(), H5F_ACC_RDWR, access);
    H5Pclose(access);
    REQUIRE(file >= 0);
    change(file);
    H5Fclose(file);
    CHECK_THROWS_WITH(read_field_hdf5(bad), Contains("bad.h5") && Contains(what));
  };
  const auto replace_velocity = [](hid_t file, std::vector<hsize_t> shape, hid_t type, bool written = true) {
    H5Ldelete(file, "velocity", H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t dataset = H5Dcreate2(file, "velocity", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const std::vector<double> zeros(180);
    if (written) H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data());
    const hid_t text = H5Tcopy(H5T_C_S1), scalar = H5Screate(H5S_SCALAR);
    H5Tset_size(text, 3);
    const hid_t units = H5Acreate2(dataset, "units", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(units, text, "m/s");
    H5Aclose(units), H5Sclose(scalar), H5Tclose(text), H5Dclose(dataset), H5Sclose(space);
  };
  refused([](hid_t file) { H5Adelete(file, "schema"); }, "has no schema");
  refused([](hid_t file) { H5Adelete(file, "schema_version"); }, "version ''");
  refused([](hid_t file) { H5Adelete(file, "outside"); }, "needed: 'zero' or 'clamp'");
  refused([](hid_t file) { H5Ldelete(file, "lower", H5P_DEFAULT); }, "dataset lower is missing");
  refused([](hid_t file) { H5Adelete_by_name(file, "velocity", "units", H5P_DEFAULT); }, "needed: 'm/s'");
  refused([&](hid_t file) { replace_velocity(file, {5, 3, 4}, H5T_IEEE_F64LE); }, "shape [5, 3, 4]; needed: [nz, ny, nx, 3]");
  refused([&](hid_t file) { replace_velocity(file, {5, 3, 4, 3}, H5T_STD_I32LE); }, "floating-point");
  // Shapes that no memory holds, and values that were never written.
  refused([&](hid_t file) { replace_velocity(file, {5, 3, 4, 3}, H5T_IEEE_F64LE, false); }, "fewer values");
  refused([&](hid_t file) { replace_velocity(file, {500, 500, 500, 3}, H5T_IEEE_F64LE, false); }, "fewer values");
  refused(
      [](hid_t file) {
        const hid_t dataset = H5Dopen2(file, "velocity", H5P_DEFAULT);
        std::vector<double> values(180, std::nan(""));
        H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        H5Dclose(dataset);
      },
      "must be finite");
  // Damaged anywhere: structure and values have checksums, so what can be read is what was written.
  const Grid original = read_field_hdf5(good).grid();
  std::mt19937 random(8);
  int found = 0;
  for (int i = 0; i < 400; ++i) {
    std::string damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
    folder.write("damaged.h5", damaged);
    try {
      const Grid grid = read_field_hdf5(folder.path / "damaged.h5").grid();
      CHECK((grid.values == original.values && grid.lower == original.lower && grid.upper == original.upper &&
             grid.points == original.points));
    } catch (const std::runtime_error& fault) {
      ++found;
      CHECK_THAT(fault.what(), Contains("damaged.h5"));
    }
  }
  CHECK(found > 100);
}

TEST_CASE("an HDF5 field file without checksums on its structure is refused before the library can stumble",
          "[dragcore][field_file][hard][regression]") {
  const Folder folder;
  // The same contents, as the library writes them by default and in the format of 1.10; texts of fixed and of variable length.
  const auto make = [&](const std::string& name, bool oldest, bool variable) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (!oldest) H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    const hid_t file = H5Fcreate((folder.path / name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), scalar = H5Screate(H5S_SCALAR);
    const auto text = [&](hid_t object, const char* key, const char* value) {
      const hid_t type = H5Tcopy(H5T_C_S1);
      H5Tset_size(type, variable ? H5T_VARIABLE : std::string_view(value).size());
      const hid_t attribute = H5Acreate2(object, key, type, scalar, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(attribute, type, variable ? static_cast<const void*>(&value) : value);
      H5Aclose(attribute), H5Tclose(type);
    };
    text(file, "schema", "dragcore.wind_field"), text(file, "schema_version", "1.0"), text(file, "outside", "zero");
    const auto numbers = [&](const char* key, std::vector<hsize_t> shape, const char* units, std::vector<double> values) {
      const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
      const hid_t dataset = H5Dcreate2(file, key, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      text(dataset, "units", units);
      H5Dclose(dataset), H5Sclose(space);
    };
    numbers("lower", {3}, "m", {0, 0, 0}), numbers("upper", {3}, "m", {1, 1, 1}), numbers("velocity", {1, 1, 1, 3}, "m/s", {1, 2, 3});
    H5Sclose(scalar), H5Fclose(file), H5Pclose(access);
    return folder.path / name;
  };
  CHECK(read_field_hdf5(make("good.h5", false, false)).velocity(Vector3d(0.5, 0.5, 0.5)) == Vector3d(1, 2, 3));
  CHECK_THROWS_WITH(read_field_hdf5(make("old.h5", true, false)),
                    Contains("its superblock is damaged, or of HDF5's oldest format") && Contains("libver='v110'"));
  CHECK_THROWS_WITH(read_field_hdf5(make("texts.h5", false, true)),
                    Contains("attribute schema is a text of variable length") && Contains("numpy.bytes_"));

  // A root or a dataset that has become one of the oldest format: its first byte is the version then.
  const std::string good = contents(folder.path / "good.h5");
  int objects = 0;
  for (std::size_t at = good.find("OHDR"); at != std::string::npos; at = good.find("OHDR", at + 1)) {
    std::string damaged = good;
    damaged[at] = 1;
    CHECK_THROWS_WITH(read_field_hdf5(folder.write("damaged.h5", damaged)), Contains("is damaged, or of HDF5's oldest format"));
    ++objects;
  }
  CHECK(objects == 4);
  // What a link says is somewhere else is not looked for there.
  const hid_t file = H5Fopen((folder.path / "good.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "lower", H5P_DEFAULT);
  H5Lcreate_external("other.h5", "/lower", file, "lower", H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  CHECK_THROWS_WITH(read_field_hdf5(folder.path / "good.h5"), Contains("dataset lower is a link to another place"));
}
