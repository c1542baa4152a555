// Manifest, seal and state of a shard as JSON on the shared folder, read strictly: they may be anyone's.
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

/// Throws nlohmann::json::exception where a value is missing or of another kind, std::runtime_error where a count is none as freeplay
/// writes it: what a fraction or a negative number would be converted to is not defined.
template <class T>
T record_of(const nlohmann::json& document) {
  for (const auto& [key, value] : document.items())
    if (value.is_boolean() ||
        (value.is_number() && !value.is_number_unsigned() && key != "seconds" && key != "when"))
      throw std::runtime_error("says what no plan does");
  return document.get<T>();
}

/// As a line of JSON; bytes that are no text are replaced.
template <class T>
std::string record_text(const T& record) {
  return nlohmann::json(record).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace freeplay
