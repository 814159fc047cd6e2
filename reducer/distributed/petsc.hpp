// SPDX-License-Identifier: GPL-3.0-or-later
// Errors of PETSc and SLEPc as exceptions.
#pragma once

#include <petscsys.h>

#include <string>

#include "common/base/error.hpp"

namespace cbr {

inline void petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  char* specific = nullptr;
  PetscErrorMessage(code, &text, &specific);
  throw RunError("PETSc: " + std::string(text != nullptr ? text : "error") +
                 (specific != nullptr && *specific != '\0' ? ": " + std::string(specific) : ""));
}

}  // namespace cbr
