// Writes JSON documents into an HDF5 file.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "plots/export/hdf5_file.hpp"

namespace freeplay::hdf5 {

/// Writes the members of an object as attributes of the group `at`. Objects in it become subgroups,
/// lists of numbers or of texts become arrays, and other values become JSON text.
void mirror(const File& file, hid_t at, const nlohmann::json& object);

/// Writes the statistics of the contacts from run.json, one dataset per field: NaN if a contact has
/// no such value; standard errors as FIELD_standard_error. A run without contacts writes nothing.
/// Returns the number of contacts.
std::size_t statistics(const File& file, hid_t at, const nlohmann::json& run);

/// Unit by the suffix of a name in result files: "m/s" for greatest_m_per_s; otherwise that of a
/// column; "" if it has none.
std::string unit_of(const std::string& name);

}  // namespace freeplay::hdf5
