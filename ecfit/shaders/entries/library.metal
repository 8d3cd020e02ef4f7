// Metal Shading Language compiled as C++ with the header beside this file: see ecfit/shaders/tools.py.
#include <metal_stdlib>
using namespace metal;

//@functions

kernel void evaluate(device const float *given [[buffer(0)]], device float *found [[buffer(1)]],
                     uint2 id [[thread_position_in_grid]]) {
  const uint row = id.y * @points@u + id.x;
  const float x0 = given[4 * row], x1 = given[4 * row + 1], x2 = given[4 * row + 2], x3 = given[4 * row + 3];
  float value = 0.0f;
  (void)x0, (void)x1, (void)x2, (void)x3;
  switch (id.y) {
//@cases
  }
  found[row] = value;
}

// What the driver of a device does: call the kernel for each point.
extern "C" void run(const float *given, float *found) {
  for (uint f = 0; f < @functions@u; ++f)
    for (uint i = 0; i < @points@u; ++i) evaluate(given, found, uint2{i, f});
}
