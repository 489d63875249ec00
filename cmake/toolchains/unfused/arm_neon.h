// The compiler's <arm_neon.h>, but what multiplies and adds rounds twice.
//
// Eigen and Highway ask for a fused multiply-add by name where the processor has one, and
// -ffp-contract=off has no say in that. 64-bit ARM always has one and plain x86-64 never; with
// these words both compute the same (see cmake/Toolchain.cmake).
#pragma once

#pragma GCC system_header
#include_next <arm_neon.h>

#if defined(__aarch64__)
#define vfma_f32(c, a, b) vadd_f32(c, vmul_f32(a, b))
#define vfma_f64(c, a, b) vadd_f64(c, vmul_f64(a, b))
#define vfmaq_f32(c, a, b) vaddq_f32(c, vmulq_f32(a, b))
#define vfmaq_f64(c, a, b) vaddq_f64(c, vmulq_f64(a, b))
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))
#endif
