@group(0) @binding(0) var<storage, read> given: array<f32>;
@group(0) @binding(1) var<storage, read_write> found: array<f32>;

//@functions

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= @points@u) { return; }
  let row = id.y * @points@u + id.x;
  let x0 = given[4u * row];
  let x1 = given[4u * row + 1u];
  let x2 = given[4u * row + 2u];
  let x3 = given[4u * row + 3u];
  var value = 0.0;
  switch (i32(id.y)) {
//@cases
    default: {}
  }
  found[row] = value;
}
