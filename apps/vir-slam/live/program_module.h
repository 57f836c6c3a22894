#pragma once

namespace vir::app {

/// The function `name` of a shared object beside the folder of the plugins (vir_module of CMake),
/// which is never closed. Throws std::runtime_error with the linker's words.
void* functionOf(const char* object, const char* name);

/// Of the module that knows DDS. Throws std::runtime_error saying what to do where there is none.
void* functionOfDds(const char* name);

}  // namespace vir::app
