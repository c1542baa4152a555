// Maps errors of the library to Python exceptions.
#pragma once

namespace freeplay::python {

/// Called once, when the module is created. The classes are in freeplay/errors.py.
void register_errors();

}  // namespace freeplay::python
