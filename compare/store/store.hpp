#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/store/surface_patches.hpp"

// Results on disk, HDF5; docs/results.md describes the layout for other programs.
//
// Every function that reads throws std::runtime_error, naming the file and what to do, when it is missing, truncated, not HDF5, not of this
// program, or of a newer major schema. Every function that writes goes through a temporary name, fsync and rename: a file is either whole
// or absent.

namespace compare {

using case_record::CaseRecord;

/// One run in full, with its surface sample. The folder must exist.
/// @throws std::invalid_argument  when a usable case holds a number that is not finite. (In a case that is not usable such numbers become
/// 0.)
void write_run(const std::filesystem::path& path, const CaseRecord& record);
CaseRecord read_run(const std::filesystem::path& path);

/// All `*.h5` of a folder, in order of case name. A folder that does not exist holds none.
std::vector<CaseRecord> read_runs(const std::filesystem::path& folder);

/// References collected from many runs: `cases[i].surface` is empty, `patches[i]` says what is kept of it.
struct Reference {
  std::vector<CaseRecord> cases;
  std::vector<std::vector<PatchMean>> patches;
};

Reference read_reference(const std::filesystem::path& path);

/// Writes nothing, and returns false, when the file already holds exactly these rows: a committed file then stays the same to the byte.
/// @param commit  revision of the program, for the file's provenance
bool write_reference(const std::filesystem::path& path, const Reference& reference, const std::string& commit);

/// Rows of `into`, each replaced by the run of the same name where there is one, and the other runs; in order of name. A run that failed
/// does not replace a usable row of the same key. @throws std::runtime_error  as patch_means() does
Reference merged(Reference into, const std::vector<CaseRecord>& runs);

/// Bodies at rest in a wind, and bodies that spin, in still air or in a wind: two kinds of case that no table, fit or gate mixes.
Reference at_rest(const Reference& reference);
std::vector<CaseRecord> spinning(const std::vector<CaseRecord>& cases);

}  // namespace compare
