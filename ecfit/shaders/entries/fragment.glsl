#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D given;
out vec4 found;

//@functions

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 x = texelFetch(given, texel, 0);
  float x0 = x.x, x1 = x.y, x2 = x.z, x3 = x.w;
  float value = 0.0;
  int f = texel.y;
//@cases
  found = vec4(value, 0.0, 0.0, 1.0);
}
