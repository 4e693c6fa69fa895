/* The extended and the unscented filter in plain C, for the speed table only.
 *
 * Same work as the package's kernels: exact step by Taylor series (8 terms, 6 for the derivatives),
 * cubic input, Joseph's form, five states (tip position and velocity, k, beta, constant force) or
 * four. Without the package's bounds, status, gaps and gate. Signs and units as in the package.
 */
#include <math.h>
#include <string.h>

enum { TERMS = 8, TANGENT_TERMS = 6, MOST = 5 };

typedef struct {
    double m, k0, b0, dt, R, q;
} Constants;

/* Advance x, v by one sample; with T, also d(x, v)/d(x, v, k, beta). w: the cubic's coefficients. */
static inline void step(const Constants *c, double k, double beta, const double w[4], double *x,
                        double *v, double T[2][4])
{
    const double im = 1.0 / c->m, h = c->dt;
    const double a0 = -h * (c->k0 + k) * im, a1 = -h * (c->b0 + beta) * im;
    const double g0 = h * c->k0 * im, g1 = c->b0 * im, hm = h * im;
    double zx = *x, zv = *v, sx = zx, sv = zv;
    double t[2][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}}, s[2][4];
    memcpy(s, t, sizeof s);
#pragma GCC unroll 8
    for (int j = 0; j < TERMS; j++) {
        const double inverse = 1.0 / (j + 1);
        if (T && j < TANGENT_TERMS) {
#pragma GCC unroll 4
            for (int i = 0; i < 4; i++) {
                double forcing = i == 2 ? -hm * zx : i == 3 ? -hm * zv : 0.0;
                double tx = h * t[1][i] * inverse;
                double tv = (a0 * t[0][i] + a1 * t[1][i] + forcing) * inverse;
                t[0][i] = tx, t[1][i] = tv;
                s[0][i] += tx, s[1][i] += tv;
            }
        }
        double forcing = j < 4 ? g0 * w[j] + (j < 3 ? g1 * (j + 1) * w[j + 1] : 0.0) : 0.0;
        double nx = h * zv * inverse, nv = (a0 * zx + a1 * zv + forcing) * inverse;
        zx = nx, zv = nv;
        sx += zx, sv += zv;
    }
    *x = sx, *v = sv;
    if (T)
        memcpy(T, s, sizeof s);
}

static inline void cubic(const double u[4], double w[4])
{
    w[0] = u[1];
    w[1] = u[0] / 3 + u[1] / 2 - u[2] + u[3] / 6;
    w[2] = (u[0] + u[2]) / 2 - u[1];
    w[3] = (u[0] - u[3]) / 6 + (u[2] - u[1]) / 2;
}

/* Take in a force; Joseph's form. */
static inline void update(const Constants *c, int n, double X[MOST], double P[MOST][MOST], double u,
                          double force)
{
    double HP[MOST], K[MOST], LPH[MOST], L[MOST][MOST];
    const double h4 = n == 5 ? 1.0 : 0.0;
    for (int j = 0; j < n; j++)
        HP[j] = -c->k0 * P[0][j] + (n == 5 ? h4 * P[4][j] : 0.0);
    double S = -c->k0 * HP[0] + (n == 5 ? HP[4] : 0.0) + c->R, inverse = 1.0 / S;
    double innovation = force - (c->k0 * (u - X[0]) + (n == 5 ? X[4] : 0.0));
    for (int i = 0; i < n; i++)
        K[i] = HP[i] * inverse;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            L[i][j] = P[i][j] - K[i] * HP[j];
    for (int i = 0; i < n; i++)
        LPH[i] = K[i] * c->R - (-c->k0 * L[i][0] + (n == 5 ? L[i][4] : 0.0));
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++)
            P[i][j] = P[j][i] = L[i][j] + LPH[i] * K[j];
        X[i] += K[i] * innovation;
    }
}

static inline void predict_extended(const Constants *c, int n, double X[MOST], double P[MOST][MOST],
                                    const double w[4])
{
    double T[2][4], FP[2][MOST], N[2][MOST];
    step(c, X[2], X[3], w, &X[0], &X[1], T);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < n; j++)
            FP[i][j] = T[i][0] * P[0][j] + T[i][1] * P[1][j] + T[i][2] * P[2][j] + T[i][3] * P[3][j];
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++)
            N[i][j] = FP[i][0] * T[j][0] + FP[i][1] * T[j][1] + FP[i][2] * T[j][2] + FP[i][3] * T[j][3];
        for (int j = 2; j < n; j++)
            N[i][j] = FP[i][j];
    }
    N[1][1] += c->q;
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < n; j++)
            P[i][j] = P[j][i] = N[i][j];
}

static inline void predict_unscented(const Constants *c, double X[MOST], double P[MOST][MOST],
                                     const double w[4])
{
    enum { n = 4 };
    const double kappa = 2.0, w0 = kappa / (n + kappa), wi = 0.5 / (n + kappa);
    const double root = sqrt(n + kappa);
    double U[n][n] = {{0}}, points[2 * n + 1][n], mean[n] = {0}, T[2][4];
#pragma GCC unroll 4
    for (int j = n - 1; j >= 0; j--) {
        double pivot = P[j][j];
#pragma GCC unroll 4
        for (int k = j + 1; k < n; k++)
            pivot -= U[j][k] * U[j][k];
        U[j][j] = sqrt(pivot > 0 ? pivot : 0);
        double inverse = pivot > 0 ? 1.0 / U[j][j] : 0.0;
#pragma GCC unroll 4
        for (int i = 0; i < j; i++) {
            double rest = P[i][j];
#pragma GCC unroll 4
            for (int k = j + 1; k < n; k++)
                rest -= U[i][k] * U[j][k];
            U[i][j] = rest * inverse;
        }
    }
    memcpy(points[0], X, sizeof points[0]);
    step(c, X[2], X[3], w, &points[0][0], &points[0][1], T);
#pragma GCC unroll 4
    for (int i = 0; i < n; i++)
#pragma GCC unroll 2
        for (int sign = 0; sign < 2; sign++) {
            double *p = points[1 + 2 * i + sign], r = sign ? -root : root;
            if (i < 2) {
                memcpy(p, points[0], sizeof points[0]);
                p[0] += r * (T[0][0] * U[0][i] + T[0][1] * U[1][i]);
                p[1] += r * (T[1][0] * U[0][i] + T[1][1] * U[1][i]);
            } else {
                for (int j = 0; j < n; j++)
                    p[j] = X[j] + r * U[j][i];
                step(c, p[2], p[3], w, &p[0], &p[1], 0);
            }
        }
    for (int j = 0; j < n; j++) {
        mean[j] = w0 * points[0][j];
        for (int i = 1; i < 2 * n + 1; i++)
            mean[j] += wi * points[i][j];
    }
    for (int i = 0; i < n; i++)
        for (int j = i; j < n; j++) {
            double sum = w0 * (points[0][i] - mean[i]) * (points[0][j] - mean[j]);
            for (int p = 1; p < 2 * n + 1; p++)
                sum += wi * (points[p][i] - mean[i]) * (points[p][j] - mean[j]);
            P[i][j] = P[j][i] = sum;
        }
    P[1][1] += c->q;
    memcpy(X, mean, sizeof mean);
}

#define FILTER(name, n, predict)                                                                   \
    void name(const double *position, const double *force, long count, const double *constants,    \
              const double *variances, double *stiffness, double *damping)                         \
    {                                                                                              \
        Constants c;                                                                               \
        memcpy(&c, constants, sizeof c);                                                           \
        double X[MOST] = {0}, P[MOST][MOST] = {{0}}, u[4], w[4];                                   \
        for (int i = 0; i < n; i++)                                                                \
            P[i][i] = variances[i];                                                                \
        for (long t = 0; t < count; t++) {                                                         \
            if (t > 0) {                                                                           \
                u[0] = position[t], u[1] = position[t - 1];                                        \
                u[2] = t > 1 ? position[t - 2] : 2 * u[1] - u[0];                                  \
                u[3] = t > 2 ? position[t - 3] : 3 * u[2] - 3 * u[1] + u[0];                       \
                cubic(u, w);                                                                       \
                predict;                                                                           \
            }                                                                                      \
            update(&c, n, X, P, position[t], force[t]);                                            \
            stiffness[t] = X[2], damping[t] = X[3];                                                \
        }                                                                                          \
    }

FILTER(ekf, 4, predict_extended(&c, 4, X, P, w))
FILTER(ekf_offset, 5, predict_extended(&c, 5, X, P, w))
FILTER(ukf, 4, predict_unscented(&c, X, P, w))
