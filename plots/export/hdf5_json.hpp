// JSON documents in an HDF5 file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "plots/export/hdf5_file.hpp"

namespace freeplay::hdf5 {

/// An object's members as attributes of the group `at`; objects in it are groups below. Lists of numbers or of texts are
/// arrays, any others JSON text.
void mirror(const File& file, hid_t at, const nlohmann::json& object);

/// What run.json says of each contact: a dataset each, NaN where a contact has no such value; standard errors as
/// FIELD_standard_error. Nothing of a run without contacts. How many contacts there are.
std::size_t statistics(const File& file, hid_t at, const nlohmann::json& run);

/// By the end of a name, as result files have them: "m/s" of greatest_m_per_s; else that of a column; "" where it has none.
std::string unit_of(const std::string& name);

}  // namespace freeplay::hdf5
