// Draw calls and dispatches that count, and that do nothing while no program is in use.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/gpu/objects.h"

namespace scree::gpu {

// `mode`: GL_TRIANGLES, ...; `type` of indices: GL_UNSIGNED_SHORT or GL_UNSIGNED_INT; byte offsets
// into the bound index or indirect buffer. Calls with a count of 0 are dropped, and not counted.
void drawArrays(unsigned mode, int first, int count);
void drawArraysInstanced(unsigned mode, int first, int count, int instances,
                         unsigned base_instance = 0);
void drawElements(unsigned mode, int count, unsigned type, size_t offset = 0, int base_vertex = 0);
void drawElementsInstanced(unsigned mode, int count, unsigned type, size_t offset, int instances,
                           int base_vertex = 0, unsigned base_instance = 0);
// Commands of struct DrawArrays/DrawElementsIndirectCommand, from `buffer` at `offset`.
void drawArraysIndirect(unsigned mode, const Buffer& buffer, size_t offset, int commands = 1,
                        int stride = 0);
void drawElementsIndirect(unsigned mode, unsigned type, const Buffer& buffer, size_t offset,
                          int commands = 1, int stride = 0);

// Draws vertices that the shader makes from gl_VertexID, without attributes.
void drawVertexless(unsigned mode, int count, int instances = 1, unsigned base_instance = 0);
// The same by commands of struct DrawArraysIndirectCommand.
void drawVertexlessIndirect(unsigned mode, const Buffer& buffer, size_t offset, int commands = 1, int stride = 0);
// One triangle that covers the viewport: three vertices without attributes; see
// shaders/lib for the vertex shader.
void drawFullScreen();

// Work groups along x, y, z. Ends the program beyond limits().work_groups.
void dispatch(uint32_t x, uint32_t y = 1, uint32_t z = 1);
// Enough groups of `group_size` for `items` along x.
void dispatchItems(uint64_t items, uint32_t group_size);
void dispatchIndirect(const Buffer& buffer, size_t offset = 0);

// glMemoryBarrier. Frame issues those between passes; only steps inside a pass need their own.
void barrier(unsigned bits);

}  // namespace scree::gpu
