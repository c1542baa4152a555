// JSON records of a division (manifest, seal, state of a shard). They are on a shared folder and
// may be of unknown origin, so values are checked strictly.
#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "io/files/input_file.hpp"
#include "study/partition/shard.hpp"

namespace freeplay {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Manifest, format, plan, verb, arguments, subject, program, units_digest,
                                   shards, units)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Seal, plan, file, checksum, bytes, units, failed, reasons, seconds, host)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ShardState, state, reason, host, job, done, total, seconds,
                                                when)

/// Reads a record. Throws nlohmann::json::exception for a missing value or a value of another type,
/// and std::runtime_error for a count that is negative or fractional: its conversion would be
/// undefined.
template <class T>
T record_of(const nlohmann::json& document) {
  for (const auto& [key, value] : document.items())
    if (value.is_boolean() ||
        (value.is_number() && !value.is_number_unsigned() && key != "seconds" && key != "when"))
      throw std::runtime_error("says what no plan does");
  return document.get<T>();
}

/// A record as JSON text. Bytes that are not UTF-8 are replaced.
template <class T>
std::string record_text(const T& record) {
  return nlohmann::json(record).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace freeplay
