#version 450
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given { float given[]; };
layout(std430, binding = 1) buffer Found { float found[]; };

//@functions

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const int f = int(gl_WorkGroupID.y);
  if (i >= @points@u) return;
  const uint row = uint(f) * @points@u + i;
  const float x0 = given[4u * row], x1 = given[4u * row + 1u], x2 = given[4u * row + 2u], x3 = given[4u * row + 3u];
  float value = 0.0;
//@cases
  found[row] = value;
}
