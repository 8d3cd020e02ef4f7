[[vk::binding(0, 0)]] StructuredBuffer<float> given : register(t0);
[[vk::binding(1, 0)]] RWStructuredBuffer<float> found : register(u1);

//@functions

[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  if (id.x >= @points@u) return;
  const uint row = id.y * @points@u + id.x;
  const float x0 = given[4u * row], x1 = given[4u * row + 1u], x2 = given[4u * row + 2u], x3 = given[4u * row + 3u];
  float value = 0.0;
  switch (id.y) {
//@cases
  }
  found[row] = value;
}
