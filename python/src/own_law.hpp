// A function of Python as the normal force of contacts.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "model/own_law.hpp"

namespace freeplay::python {

/// f(contact, penetration, rate, touch speed) in N; `what` tells it from any other. What it raises leaves the run.
std::shared_ptr<const OwnLaw> law_of(const pybind11::function& f, const std::string& name,
                                     const std::string& what);

}  // namespace freeplay::python
