// What claims and tests of runs share: scenes as text, methods, and runs that have to finish.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "facade/simulation.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "simulation/observer.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"
#include "verification/support/ways.hpp"
