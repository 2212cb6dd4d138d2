// The words of Metal that naga writes, for nvcc.
#pragma once
#include <cstdint>
#include <cstring>

struct Arguments {
    void* buffer[12];
    unsigned bytes[12];
    // Single records.
    alignas(16) unsigned one[12][32];
};

namespace metal {
using uint = unsigned;
struct __align__(16) uint4 {
    uint x, y, z, w;
    uint4() = default;
    __device__ uint4(uint x, uint y, uint z, uint w) : x(x), y(y), z(z), w(w) {}
};
struct uint3 { uint x, y, z; };
struct packed_float3 { float x, y, z; };
struct float3 { float x, y, z; };

enum class mem_flags { mem_threadgroup };
__device__ __forceinline__ void threadgroup_barrier(mem_flags) { __syncthreads(); }
__device__ __forceinline__ uint clz(uint x) { return __clz(x); }
__device__ __forceinline__ uint ctz(uint x) { return x == 0 ? 32 : __ffs(x) - 1; }
__device__ __forceinline__ uint popcount(uint x) { return __popc(x); }
__device__ __forceinline__ uint reverse_bits(uint x) { return __brev(x); }
__device__ __forceinline__ float clamp(float x, float low, float high) { return fminf(fmaxf(x, low), high); }
__device__ __forceinline__ float sqrt(float x) { return sqrtf(x); }
__device__ __forceinline__ float rint(float x) { return rintf(x); }
__device__ __forceinline__ float sin(float x) { return sinf(x); }
__device__ __forceinline__ float cos(float x) { return cosf(x); }
template <class T> __device__ __forceinline__ T select(T otherwise, T then, bool condition) { return condition ? then : otherwise; }
}  // namespace metal

using metal::uint;

template <class To, class From> __device__ __forceinline__ To as_type(From from) {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    memcpy(&to, &from, sizeof(to));
    return to;
}

template <class T> __device__ __forceinline__ metal::uint3 uint3_of(T v) { return {v.x, v.y, v.z}; }
