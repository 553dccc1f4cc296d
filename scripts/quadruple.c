/* Turning points and nutation period of one start in quadruple precision, without any code of the project.

   With y = atanh(sin(tilt)), s = roll + precession sin(tilt) and p = precession cos(tilt)^2, all scaled by sqrt(R/g),
   every motion satisfies s' = -p/(1+alpha), p' = -2 s/cosh(y)^2, with the potential
   V = (1+alpha)/2 s^2 + (alpha/4) p^2 cosh(y)^2 + 1/cosh(y); (2+alpha)/4 (dtilt/dt)^2 = h - V.
   V - h is expanded in Taylor series on panels that extend from the start in both directions; positions are distances x
   in y from the start. The first panel never computes V(start), so that tiny swings keep all digits. */
#include <math.h>
#include <quadmath.h>
#include <string.h>

typedef __float128 quad;
enum { TERMS = 28, REACH = 120, MOST_TOPS = 40, MOST_NODES = 24 };
static const quad PANEL = 0.125Q;

typedef struct {
    quad alpha, w, y, s, p, unit;
    quad excess[2 * REACH + 1][TERMS], s_at[2 * REACH + 1], p_at[2 * REACH + 1];
    char made[2 * REACH + 1];
    quad tops[MOST_TOPS];
    int top_count;
} Motion;

/* Computes the Taylor coefficients of the excess V - h on panel k, and the rates on the adjacent panels. */
static void expand(Motion *m, int k) {
    quad y = m->y + k * PANEL, a = 1 + m->alpha, factorial = 1;
    quad sech[TERMS], sech2[TERMS], tanh[TERMS], cosh[TERMS], s[TERMS], p[TERMS], o[TERMS];
    sech[0] = 1 / coshq(y), tanh[0] = tanhq(y), sech2[0] = sech[0] * sech[0], cosh[0] = coshq(y);
    s[0] = m->s_at[k + REACH], p[0] = m->p_at[k + REACH];
    for (int n = 0; n + 1 < TERMS; n++) {
        quad of_sech = 0, of_sech2 = 0, pull = 0;
        for (int i = 0; i <= n; i++) {
            of_sech -= sech[i] * tanh[n - i];
            of_sech2 -= 2 * sech2[i] * tanh[n - i];
            pull -= 2 * sech2[i] * s[n - i];
        }
        factorial *= n + 1;
        cosh[n + 1] = (n % 2 ? coshq(y) : sinhq(y)) / factorial;
        tanh[n + 1] = sech2[n] / (n + 1), sech[n + 1] = of_sech / (n + 1), sech2[n + 1] = of_sech2 / (n + 1);
        s[n + 1] = -p[n] / (a * (n + 1)), p[n + 1] = pull / (n + 1);
    }
    for (int n = 0; n < TERMS; n++) {
        o[n] = 0;
        for (int i = 0; i <= n; i++) o[n] += p[i] * cosh[n - i];
    }
    quad *excess = m->excess[k + REACH], kinetic = (2 + m->alpha) / 4 * m->w * m->w, o_0 = m->p * coshq(m->y);
    for (int n = 0; n < TERMS; n++) {
        excess[n] = sech[n];
        for (int i = 0; i <= n; i++) excess[n] += a / 2 * s[i] * s[n - i] + m->alpha / 4 * o[i] * o[n - i];
    }
    excess[0] -= kinetic + a / 2 * m->s * m->s + m->alpha / 4 * o_0 * o_0 + 1 / coshq(m->y);
    if (k == 0) excess[0] = -kinetic;
    m->made[k + REACH] = 1;
    for (int j = k - 1; j <= k + 1; j += 2) {
        if (j < -REACH || j > REACH || m->made[j + REACH]) continue;
        quad s_there = 0, p_there = 0;
        for (int n = TERMS - 1; n >= 0; n--) {
            s_there = s_there * (j - k) * PANEL + s[n];
            p_there = p_there * (j - k) * PANEL + p[n];
        }
        m->s_at[j + REACH] = s_there, m->p_at[j + REACH] = p_there;
    }
}

static quad excess(Motion *m, quad x, quad *slope) {
    int k = (int)rintq(x / PANEL), step = k < 0 ? -1 : 1;
    for (int j = 0; j != k + step; j += step)
        if (!m->made[j + REACH]) expand(m, j);
    quad t = x - k * PANEL, value = 0, derivative = 0;
    for (int n = TERMS - 1; n >= 0; n--) {
        derivative = derivative * t + value;
        value = value * t + m->excess[k + REACH][n];
    }
    if (slope) *slope = derivative;
    return value;
}

/* Returns where the excess, or its slope, changes sign between two positions, by bisection. */
static quad change(Motion *m, quad low, quad high, int of_slope) {
    quad slope, first = excess(m, low, &slope);
    if (of_slope) first = slope;
    for (int i = 0; i < 130; i++) {
        quad middle = (low + high) / 2, value = excess(m, middle, &slope);
        if (of_slope) value = slope;
        if ((value > 0) == (first > 0)) low = middle;
        else high = middle;
    }
    return (low + high) / 2;
}

/* Finds the turning point on one side, if there is one before `last` in y; records the maxima of V on the way, and the
   next one if it is near. */
static int turn(Motion *m, int side, quad last, quad *where) {
    quad slope, before = 0, rise_before;
    excess(m, 0, &slope);
    rise_before = side * slope;
    if (m->w == 0 && rise_before > 0) return *where = 0, 1;
    int turned = 0;
    for (quad x = 1e-16Q, end = 1e9Q; x < end; x = fminq(1.2Q * x, x + 0.01Q)) {
        if (side * m->y + x >= last) x = end = last - side * m->y;
        quad value = excess(m, side * x, &slope), rise = side * slope;
        if (rise_before > 0 && rise <= 0 && m->top_count < MOST_TOPS) {
            quad top = m->tops[m->top_count++] = change(m, side * before, side * x, 1);
            if (!turned && excess(m, top, 0) > 0) return *where = change(m, side * before, top, 0), 1;
        }
        if (!turned && value > 0) *where = change(m, side * before, side * x, 0), turned = 1, end = x + 0.7Q;
        before = x, rise_before = rise;
    }
    return turned;
}

static quad nodes[2][MOST_NODES], weights[2][MOST_NODES];
static const int node_count[2] = {16, MOST_NODES};

/* Computes the nodes and weights of Gauss and Legendre; must be called once, before everything else. */
void prepare(void) {
    for (int rule = 0; rule < 2; rule++)
        for (int i = 0, n = node_count[rule]; i < n; i++) {
            quad x = cosq(M_PIq * (i + 0.75Q) / (n + 0.5Q)), slope = 1;
            for (int newton = 0; newton < 12; newton++) {
                quad a = 1, b = x;
                for (int j = 2; j <= n; j++) {
                    quad c = ((2 * j - 1) * x * b - (j - 1) * a) / j;
                    a = b, b = c;
                }
                slope = n * (x * b - a) / (x * x - 1);
                x -= b / slope;
            }
            nodes[rule][i] = x, weights[rule][i] = 2 / ((1 - x * x) * slope * slope);
        }
}

typedef struct {
    Motion *motion;
    quad low, half, doubt;
} Swing;

static quad gauss(const Swing *swing, quad from, quad to, int rule) {
    quad sum = 0;
    for (int i = 0; i < node_count[rule]; i++) {
        quad angle = (from + to) / 2 + (to - from) / 2 * nodes[rule][i];
        quad x = swing->low + swing->half * (1 + sinq(angle));
        quad square = -excess(swing->motion, x, 0), y = swing->motion->y + x;
        sum += weights[rule][i] * swing->half * cosq(angle) / (coshq(y) * sqrtq(square));
    }
    return sum * (to - from) / 2;
}

/* Halves an interval until two rules agree; their difference is added to the doubt. */
static quad integrate(Swing *swing, quad from, quad to, int depth) {
    quad coarse = gauss(swing, from, to, 0), fine = gauss(swing, from, to, 1), apart = fabsq(coarse - fine);
    if (!(apart > 1e-14Q * fabsq(fine)) || depth == 200) return swing->doubt += apart, fine;
    quad middle = (from + to) / 2;
    return integrate(swing, from, middle, depth + 1) + integrate(swing, middle, to, depth + 1);
}

/* `start` contains tilt, tilt rate, precession rate, roll rate, alpha, radius, gravity; `found` gets the period [s], its
   relative doubt, and the least and greatest tilt [rad]. Returns 1 if the disk turns on both sides before `fall` [rad]. */
int swing(const double *start, double fall, double *found) {
    Motion motion, *m = &motion;
    memset(m->made, 0, sizeof m->made);
    quad sine = sinq(start[0]), cosine = cosq(start[0]), last = asinhq(tanq(fall)), low, high;
    m->alpha = start[4], m->unit = sqrtq((quad)start[5] / (quad)start[6]), m->top_count = 0;
    m->w = m->unit * (quad)start[1], m->y = asinhq(sine / cosine);
    m->s = m->s_at[REACH] = m->unit * ((quad)start[3] + (quad)start[2] * sine);
    m->p = m->p_at[REACH] = m->unit * (quad)start[2] * cosine * cosine;
    if (!turn(m, -1, last, &low) || !turn(m, 1, last, &high) || !(low < high)) return 0;
    /* the integrand peaks at maxima of V */
    quad cuts[MOST_TOPS + 1], total = 0, from = -M_PI_2q;
    int count = 0;
    Swing all = {m, low, (high - low) / 2, 0};
    for (int i = 0; i < m->top_count; i++)
        if (low < m->tops[i] && m->tops[i] < high) cuts[count++] = asinq((m->tops[i] - low) / all.half - 1);
    cuts[count++] = M_PI_2q;
    for (int i = 0; i < count; i++) {
        for (int j = i + 1; j < count; j++)
            if (cuts[j] < cuts[i]) { quad other = cuts[i]; cuts[i] = cuts[j], cuts[j] = other; }
        total += integrate(&all, from, cuts[i], 0);
        from = cuts[i];
    }
    found[0] = (double)(sqrtq(2 + m->alpha) * total * m->unit), found[1] = (double)(all.doubt / total);
    found[2] = (double)atanq(sinhq(m->y + low)), found[3] = (double)atanq(sinhq(m->y + high));
    return 1;
}
