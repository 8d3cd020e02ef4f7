"""Names that mean something else in a language: keywords, types and functions that ours could hide."""

import keyword

_C = """
auto break case char const continue default do double else enum extern float for goto if inline int long
register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
_Bool _Complex _Imaginary
"""
_MATH = """
abs acos asin atan atan2 ceil clamp cos cosh cross degrees determinant distance dot exp exp2 floor fma fract
inverse inversesqrt isinf isnan ldexp length log log2 log10 max min mix mod modf normalize pow radians reflect
refract round rsqrt saturate select sign sin sinh smoothstep sqrt step tan tanh transpose trunc
"""
_LIBRARY = """
main fabs fabsf sqrtf expf exp2f logf powf fmin fmax fminf fmaxf j0 j1 jn y0 y1 yn gamma lgamma tgamma erf
erfc hypot cbrt div free malloc remove rename signal time
"""
_CPP = """
alignas alignof and and_eq asm bitand bitor bool catch char8_t char16_t char32_t class co_await co_return
co_yield compl concept const_cast consteval constexpr constinit decltype delete dynamic_cast explicit export
false friend mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public
reinterpret_cast requires static_assert static_cast std template this thread_local throw true try typeid
typename using virtual wchar_t xor xor_eq
"""
_SHADER = """
bool true false half fixed unsigned uint void in out inout discard struct uniform varying attribute buffer
shared sampler sampler2D texture const static inline class template this typedef using namespace input output
precision lowp mediump highp flat smooth centroid invariant layout volatile restrict readonly writeonly
vec2 vec3 vec4 ivec2 ivec3 ivec4 uvec2 uvec3 uvec4 bvec2 bvec3 bvec4 mat2 mat3 mat4 float2 float3 float4
half2 half3 half4 int2 int3 int4 uint2 uint3 uint4 float2x2 float3x3 float4x4 matrix vector lerp frac ddx ddy
dFdx dFdy fwidth patch sample subroutine noise common partition active asm cast double external filter goto
hvec2 interface long namespace noinline public sizeof short superp union unsigned
"""
_HLSL = """
cbuffer tbuffer groupshared register row_major column_major packoffset technique pass string export linear
nointerpolation noperspective unorm snorm triangle line point SamplerState Texture2D mul rcp
"""
_SLANG = """
import module public internal private extension associatedtype func let var where no_diff each expand
throws try catch enum property get set is as new interface implementing
"""
_METAL = """
kernel vertex fragment device constant thread threadgroup metal packed_float3 texture2d access simdgroup
"""
_WGSL = """
alias break case const const_assert continue continuing default diagnostic discard else enable false fn for if
let loop override requires return struct switch true var while f16 f32 i32 u32 vec2 vec3 vec4 vec2f vec3f
vec4f array atomic ptr bool mat2x2 mat3x3 mat4x4 texture sampler function private workgroup uniform storage
NULL Self abstract active alignas alignof as asm asm_fragment async attribute auto await become cast catch
class co_await co_return co_yield coherent column_major common compile compile_fragment concept const_cast
consteval constexpr constinit crate debugger decltype delete demote demote_to_helper do dynamic_cast enum
explicit export extends extern external fallthrough filter final finally friend from fxgroup get goto
groupshared highp impl implements import inline instanceof interface layout lowp macro macro_rules match
mediump meta mod module move mut mutable namespace new nil noexcept noinline nointerpolation non_coherent
noncoherent noperspective null nullptr of operator package packoffset partition pass patch
pixelfragment precise precision premerge priv protected pub public readonly ref regardless register
reinterpret_cast require resource restrict self set shared sizeof smooth snorm static static_assert
static_cast std subroutine super target template this thread_local throw trait try type typedef typeid
typename typeof union unless unorm unsafe unsized use using varying virtual volatile wgsl where with writeonly
yield
"""
# Shader globals of OSL too: a local of that name would hide one.
_OSL = """
and break closure color continue do else emit float for if illuminance illuminate int matrix normal not or
output point public return string struct vector void while bool case catch char class const delete default
double enum extern false friend goto inline long new operator private protected short signed sizeof static
switch template this throw true try typedef uniform union unsigned varying virtual volatile shader surface
displacement volume P I N Ng dPdu dPdv Ps u v time dtime dPdtime Ci emission diffuse reflection refraction
transparent holdout background noise texture environment trace
"""


def _words(*texts: str) -> frozenset[str]:
    return frozenset(" ".join(texts).split())


RESERVED: dict[str, frozenset[str]] = {
    "glsl": _words(_C, _SHADER, _MATH, "main"),
    "hlsl": _words(_C, _SHADER, _HLSL, _MATH, "main"),
    "wgsl": _words(_WGSL, _MATH, "main"),
    "msl": _words(_C, _CPP, _SHADER, _METAL, _MATH, "main"),
    "slang": _words(_C, _SHADER, _HLSL, _SLANG, _MATH, "main"),
    "osl": _words(_OSL, _MATH, "main"),
    "c": _words(_C, _MATH, _LIBRARY, "bool true false inline alignas static_assert nullptr typeof"),
    "cpp": _words(_C, _CPP, _MATH, _LIBRARY),
    # The module, and the argument that stands for it.
    "python": frozenset({*keyword.kwlist, "numpy", "xp"}),
}
