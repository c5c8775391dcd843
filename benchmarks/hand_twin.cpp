// hand_twin.cpp - the filter `magyq` in C++, a yardstick for the compiled kernel: the same algorithm with the same updates and detectors
// on every sample, 10 states in rows of 12, outputs of attitude, its covariance and offsets. Plain loops over fixed sizes, no intrinsics.
#include <cmath>
#include <cstdint>
#include <cstring>
typedef double d;
#define INL static inline __attribute__((always_inline))

INL void exp_quat(d x, d y, d z, d *r) {
    d t2 = 0.25*(x*x + y*y + z*z), c, s;
    if (t2 < 0.0625) {
        c = 1 - t2*(1./2 - t2*(1./24 - t2*(1./720 - t2*(1./40320 - t2*(1./3628800 - t2/479001600.)))));
        s = 1 - t2*(1./6 - t2*(1./120 - t2*(1./5040 - t2*(1./362880 - t2*(1./39916800 - t2/6227020800.)))));
    } else { d t = std::sqrt(t2); c = std::cos(t); s = std::sin(t)/t; }
    s *= 0.5; r[0] = c; r[1] = s*x; r[2] = s*y; r[3] = s*z;
}
INL void qmul(const d *a, const d *b, d *o) {
    d w = a[0]*b[0] - a[1]*b[1] - a[2]*b[2] - a[3]*b[3], x = a[0]*b[1] + a[1]*b[0] + a[2]*b[3] - a[3]*b[2];
    d y = a[0]*b[2] - a[1]*b[3] + a[2]*b[0] + a[3]*b[1], z = a[0]*b[3] + a[1]*b[2] - a[2]*b[1] + a[3]*b[0];
    o[0] = w; o[1] = x; o[2] = y; o[3] = z;
}
INL void qnorm(d *q) { d n = 1/std::sqrt(q[0]*q[0] + q[1]*q[1] + q[2]*q[2] + q[3]*q[3]); for (int i = 0; i < 4; i++) q[i] *= n; }
INL void dcm(const d *q, d *C) {
    d w = q[0], x = q[1], y = q[2], z = q[3];
    C[0] = 1 - 2*(y*y + z*z); C[1] = 2*(x*y - w*z); C[2] = 2*(x*z + w*y); C[3] = 2*(x*y + w*z); C[4] = 1 - 2*(x*x + z*z);
    C[5] = 2*(y*z - w*x); C[6] = 2*(x*z - w*y); C[7] = 2*(y*z + w*x); C[8] = 1 - 2*(x*x + y*y);
}

struct Filter {
    alignas(64) d P[10][12], HP[3][12], e[12];
    d x[10];                                    // q, b_q, b_a
    d step[4], D[4][3];                         // rotation of the sample and its derivative to b_q

    // P <- Phi P Phi^T + Q, Phi = {q<-q: A = C(q_w) (I - q q^T), q<-b_q: B, b_a<-b_a: decay}; the updates before leave P along q to this
    void predict(const d *w, d dt, d qq, d qb, d qa, d decay) {
        d r[4]; exp_quat(w[0]*dt, w[1]*dt, w[2]*dt, r); for (int i = 0; i < 3; i++) r[1+i] -= x[4+i];
        d n = 1/std::sqrt(r[0]*r[0] + r[1]*r[1] + r[2]*r[2] + r[3]*r[3]); for (int i = 0; i < 4; i++) step[i] = r[i]*n;
        for (int i = 0; i < 4; i++) for (int j = 0; j < 3; j++) D[i][j] = n*(step[i]*step[1+j] - (i == 1+j));
        d a = step[0], b = step[1], c = step[2], f = step[3], p[4]; qmul(x, step, p);
        d q[4] = {x[0], x[1], x[2], x[3]}, A[4][4] = {{a,-b,-c,-f},{b,a,f,-c},{c,-f,a,b},{f,c,-b,a}};
        d U[4][3] = {{-q[1],-q[2],-q[3]},{q[0],-q[3],q[2]},{q[3],q[0],-q[1]},{-q[2],q[1],q[0]}}, B[4][3];
        for (int i = 0; i < 4; i++) { for (int j = 0; j < 4; j++) A[i][j] -= p[i]*q[j]; for (int j = 0; j < 3; j++) B[i][j] = n*(p[i]*step[1+j] - U[i][j]); }
        for (int i = 0; i < 4; i++) x[i] = p[i]; qnorm(x); for (int i = 7; i < 10; i++) x[i] *= decay;
        alignas(64) d M[4][12];
        for (int k = 0; k < 12; k++) { d s = k > 6 && k < 10 ? decay : 1;
            for (int i = 0; i < 4; i++) { d t = 0; for (int j = 0; j < 4; j++) t += A[i][j]*P[j][k]; for (int j = 0; j < 3; j++) t += B[i][j]*P[4+j][k]; M[i][k] = s*t; }
            for (int i = 4; i < 7; i++) P[i][k] *= s; for (int i = 7; i < 10; i++) P[i][k] *= s*decay; }
        for (int i = 0; i < 4; i++) for (int k = 4; k < 12; k++) P[i][k] = M[i][k];
        for (int k = 4; k < 10; k++) for (int i = 0; i < 4; i++) P[k][i] = M[i][k];
        for (int i = 0; i < 4; i++) for (int k = i; k < 4; k++) { d s = qq*((i == k) - x[i]*x[k]); for (int j = 0; j < 4; j++) s += M[i][j]*A[k][j]; for (int j = 0; j < 3; j++) s += M[i][4+j]*B[k][j]; P[i][k] = P[k][i] = s; }
        for (int i = 0; i < 3; i++) { P[4+i][4+i] += qb; P[7+i][7+i] += qa; }
    }
    // H has its entries in the columns [first, last); only those rows of P are read
    template <int first, int last> d update(const d (*H)[10], const d *z, d R, d limit) {
        for (int i = 0; i < 3; i++) for (int j = 0; j < 12; j++) { d s = 0; for (int k = first; k < last; k++) s += H[i][k]*P[k][j]; HP[i][j] = s; }
        return finish<first, last>(H, z, R, limit);
    }
    template <int first, int last> d finish(const d (*H)[10], const d *z, d R, d limit) {
        d S[3][3]; for (int i = 0; i < 3; i++) for (int j = 0; j <= i; j++) { d s = i == j ? R : 0; for (int k = first; k < last; k++) s += HP[i][k]*H[j][k]; S[i][j] = s; }
        d i0 = 1/S[0][0], l10 = S[1][0]*i0, l20 = S[2][0]*i0, t11 = S[1][1] - l10*S[1][0], t21 = S[2][1] - l20*S[1][0], t22 = S[2][2] - l20*S[2][0];
        d i1 = 1/t11, i2 = t11/(t11*t22 - t21*t21), l21 = t21*i1, r0 = std::sqrt(i0), r1 = std::sqrt(i1), r2 = std::sqrt(i2);
        d z1 = z[1] - l10*z[0], z2 = z[2] - l20*z[0] - l21*z1, y0 = z[0]*r0, y1 = z1*r1, y2 = z2*r2, nis = y0*y0 + y1*y1 + y2*y2, e0 = z[0]*i0, e1 = z1*i1, e2 = z2*i2;
        if (nis > limit) return nis;
        for (int j = 0; j < 12; j++) { d u = HP[0][j], v = HP[1][j] - l10*u, t = HP[2][j] - l20*u - l21*v; HP[0][j] = u*r0; HP[1][j] = v*r1; HP[2][j] = t*r2; e[j] = e0*u + e1*v + e2*t; }
        for (int i = 0; i < 10; i++) x[i] += e[i];
        qnorm(x);
        for (int i = 0; i < 10; i++) { d u = HP[0][i], v = HP[1][i], t = HP[2][i]; for (int j = 0; j < 12; j++) P[i][j] = P[i][j] - u*HP[0][j] - v*HP[1][j] - t*HP[2][j]; }
        return nis;
    }
    // quasi-static field: z = r - q y q*
    template <bool force> d field(const d *m, const d *r, d R, d limit) {
        d C[9]; dcm(x, C); d y[3], z[3]; for (int i = 0; i < 3; i++) y[i] = force ? m[i] - x[7+i] : m[i];
        for (int i = 0; i < 3; i++) z[i] = r[i] - (C[3*i]*y[0] + C[3*i+1]*y[1] + C[3*i+2]*y[2]);
        d w = x[0], a = x[1], b = x[2], c = x[3];
        d v0 = 2*(w*y[0] + b*y[2] - c*y[1]), v1 = 2*(w*y[1] + c*y[0] - a*y[2]), v2 = 2*(w*y[2] + a*y[1] - b*y[0]), s = 2*(a*y[0] + b*y[1] + c*y[2]);
        d H[3][10] = {{v0,s,v2,-v1},{v1,-v2,s,v0},{v2,v1,-v0,s}};
        if (force) for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) H[i][7+j] = -C[3*i+j];
        return force ? update<0, 10>(H, z, R, limit) : update<0, 4>(H, z, R, limit);
    }
    // MARU and AGU: z = y - q_w* x q_w
    template <bool force> d gradient(const d *before, const d *now, const d *used, d decay, d R, d limit) {
        d C[9]; dcm(step, C); d y[3], u[3], z[3];
        for (int i = 0; i < 3; i++) { y[i] = force ? before[i] - x[7+i]/decay : before[i]; u[i] = force ? now[i] - x[7+i] : now[i]; }
        d w = step[0], a = step[1], b = step[2], c = step[3];
        d v0 = 2*(w*y[0] - b*y[2] + c*y[1]), v1 = 2*(w*y[1] - c*y[0] + a*y[2]), v2 = 2*(w*y[2] - a*y[1] + b*y[0]), s = 2*(a*y[0] + b*y[1] + c*y[2]);
        d h[3][4] = {{v0,s,-v2,v1},{v1,v2,s,-v0},{v2,-v1,v0,s}};
        d H[3][10] = {};
        for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) { d t = 0; for (int k = 0; k < 4; k++) t += h[i][k]*D[k][j]; H[i][4+j] = t; }
        if (force) for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) H[i][7+j] = (i == j) - C[3*j+i]/decay;
        for (int i = 0; i < 3; i++) { z[i] = u[i] - (C[i]*y[0] + C[3+i]*y[1] + C[6+i]*y[2]); for (int j = 0; j < 3; j++) z[i] -= H[i][4+j]*(x[4+j] - used[j]); }
        return force ? update<4, 10>(H, z, R, limit) : update<4, 7>(H, z, R, limit);
    }
};
struct Detector {                               // eqs 33, 34 with running sums
    int n, first, count = 0, place = 0; d sum = 0, squares = 0, reference = 0; bool fixed = false; d ring[512][4], ref[3];
    bool judge(const d *y, const d *C, d g1, d g2, d *statistic) {
        d norm = std::sqrt(y[0]*y[0] + y[1]*y[1] + y[2]*y[2]), *r = ring[place];
        if (count == n) { sum -= r[0]; squares -= r[0]*r[0]; } else count++;
        r[0] = norm; sum += norm; squares += norm*norm;
        for (int i = 0; i < 3; i++) r[1+i] = C[3*i]*y[0] + C[3*i+1]*y[1] + C[3*i+2]*y[2];
        if (++place == n) { place = 0; sum = squares = 0; for (int k = 0; k < n; k++) { sum += ring[k][0]; squares += ring[k][0]*ring[k][0]; } }
        if (count < n) return false;
        auto deviation = [&](d m) { d s = (squares - 2*m*sum)/n + m*m; return std::sqrt(s > 0 ? s : 0); };
        if (fixed) { *statistic = deviation(reference); if (*statistic < g1 && std::fabs(norm - reference) <= g2) return true; fixed = false; }
        *statistic = deviation(sum/n); if (!(*statistic < g1)) return false;
        d m[4] = {}; int p = place; for (int k = 0; k < first; k++) { for (int i = 0; i < 4; i++) m[i] += ring[p][i]; if (++p == n) p = 0; }
        for (int i = 0; i < 4; i++) m[i] /= first;
        *statistic = deviation(m[0]); if (!(*statistic < g1 && std::fabs(norm - m[0]) <= g2)) return false;
        fixed = true; reference = m[0]; for (int i = 0; i < 3; i++) ref[i] = m[1+i]; return true;
    }
};
// columns: t f w m (10,n); p: dt qq qb qa decay, R of field and force, R of MARU and AGU, limit, gamma_1 and gamma_2 of field and force
extern "C" void hand(int64_t n, const d *columns, const d *p, const d *x0, const d *p0, int64_t window, int64_t first, d *nav, float *diag) {
    static Filter F; static Detector M, A; M = Detector(); A = Detector(); M.n = A.n = (int)window; M.first = A.first = (int)first;
    std::memset(&F, 0, sizeof F); for (int i = 0; i < 10; i++) { F.x[i] = x0[i]; for (int j = 0; j < 10; j++) F.P[i][j] = p0[10*i+j]; }
    d before_m[3] = {}, before_f[3] = {};
    for (int64_t k = 0; k < n; k++) {
        d f[3], w[3], m[3], used[3]; float *o = diag + 32*k; for (int i = 0; i < 32; i++) o[i] = NAN;
        for (int i = 0; i < 3; i++) { f[i] = columns[(1+i)*n+k]; w[i] = columns[(4+i)*n+k]; m[i] = columns[(7+i)*n+k]; used[i] = F.x[4+i]; }
        if (k) F.predict(w, p[0], p[1], p[2], p[3], p[4]);
        d C[9], y[3], s = NAN, t = NAN; dcm(F.x, C); for (int i = 0; i < 3; i++) y[i] = f[i] - F.x[7+i];
        bool still = A.judge(y, C, p[12], p[13], &t), steady = M.judge(m, C, p[10], p[11], &s); o[16] = (float)s; o[24] = (float)t;
        if (steady) o[22] = (float)F.gradient<false>(before_m, m, used, 1, p[7], p[9]);
        if (still) o[30] = (float)F.gradient<true>(before_f, f, used, p[4], p[8], p[9]);
        if (still) o[28] = (float)F.field<true>(f, A.ref, p[6], p[9]);
        if (steady) o[20] = (float)F.field<false>(m, M.ref, p[5], p[9]);
        for (int i = 0; i < 3; i++) { before_m[i] = m[i]; before_f[i] = f[i]; }
        d *v = nav + 11*k; v[0] = columns[k]; for (int i = 0; i < 4; i++) v[1+i] = F.x[i];
        d a = F.x[0], b = F.x[1], c = F.x[2], e = F.x[3], G[3][4] = {{2*b,-2*a,2*e,-2*c},{2*c,-2*e,-2*a,2*b},{2*e,2*c,-2*b,-2*a}}; int j = 5;
        for (int r = 0; r < 3; r++) { d q[4]; for (int i = 0; i < 4; i++) { q[i] = 0; for (int l = 0; l < 4; l++) q[i] += G[r][l]*F.P[l][i]; }
            for (int l = r; l < 3; l++) { d u = 0; for (int i = 0; i < 4; i++) u += q[i]*G[l][i]; v[j++] = u; } }
        for (int i = 0; i < 3; i++) { o[i] = (float)(2*F.x[4+i]/p[0]); o[3+i] = (float)(2*std::sqrt(F.P[4+i][4+i])/p[0]); o[6+i] = (float)F.x[7+i]; o[9+i] = (float)std::sqrt(F.P[7+i][7+i]); }
    }
}
