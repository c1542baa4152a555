// The rig of most tests: Catch2, scenes as text, methods, runs that have to finish, and their rows
// and files.
#pragma once

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "io/files/output_file.hpp"
#include "verification/support/motion_rows.hpp"
#include "verification/support/runs.hpp"
