// SPDX-License-Identifier: MIT
#include "plain_loops.h"

#if defined(__GNUC__) && defined(__x86_64__)
#define ALIDADE_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define ALIDADE_CLONES
#endif

namespace alidade {

ALIDADE_CLONES void plainProjectRadtan(const double* params, const double* R, const double* t,
                                       const double* __restrict x, const double* __restrict y,
                                       const double* __restrict z, std::size_t count, double* __restrict u,
                                       double* __restrict v) {
  const double fx = params[0], fy = params[1], cx = params[2], cy = params[3];
  const double k1 = params[4], k2 = params[5], p1 = params[6], p2 = params[7], k3 = params[8];
  const double r0 = R[0], r1 = R[1], r2 = R[2], r3 = R[3], r4 = R[4], r5 = R[5], r6 = R[6], r7 = R[7],
               r8 = R[8];
  const double tx = t[0], ty = t[1], tz = t[2];
  for (std::size_t i = 0; i < count; ++i) {
    const double iz = 1 / (r6 * x[i] + r7 * y[i] + r8 * z[i] + tz);
    const double a = (r0 * x[i] + r1 * y[i] + r2 * z[i] + tx) * iz;
    const double b = (r3 * x[i] + r4 * y[i] + r5 * z[i] + ty) * iz;
    const double s = a * a + b * b;
    const double d = 1 + s * (k1 + s * (k2 + s * k3));
    u[i] = fx * (a * d + 2 * p1 * a * b + p2 * (s + 2 * a * a)) + cx;
    v[i] = fy * (b * d + p1 * (s + 2 * b * b) + 2 * p2 * a * b) + cy;
  }
}

ALIDADE_CLONES void plainUnprojectRadtan(const double* params, const double* __restrict u,
                                         const double* __restrict v, std::size_t count, double* __restrict x,
                                         double* __restrict y) {
  const double ifx = 1 / params[0], ify = 1 / params[1], cx = params[2], cy = params[3];
  const double k1 = params[4], k2 = params[5], p1 = params[6], p2 = params[7], k3 = params[8];
  for (std::size_t i = 0; i < count; ++i) {
    const double mx = (u[i] - cx) * ifx;
    const double my = (v[i] - cy) * ify;
    double a = mx;
    double b = my;
    for (int step = 0; step < 5; ++step) {
      const double s = a * a + b * b;
      const double d = 1 + s * (k1 + s * (k2 + s * k3));
      const double e = 2 * (k1 + s * (2 * k2 + s * 3 * k3));
      const double rx = mx - (a * d + 2 * p1 * a * b + p2 * (s + 2 * a * a));
      const double ry = my - (b * d + p1 * (s + 2 * b * b) + 2 * p2 * a * b);
      const double xx = d + a * a * e + 2 * p1 * b + 6 * p2 * a;
      const double xy = a * b * e + 2 * p1 * a + 2 * p2 * b;
      const double yy = d + b * b * e + 6 * p1 * b + 2 * p2 * a;
      const double i_det = 1 / (xx * yy - xy * xy);
      a += (yy * rx - xy * ry) * i_det;
      b += (xx * ry - xy * rx) * i_det;
    }
    x[i] = a;
    y[i] = b;
  }
}

}  // namespace alidade
