"""Trouser tear of a thin sheet, static, by a code that shares nothing with the engine.

Source of the theory: R. S. Rivlin, A. G. Thomas, Rupture of rubber I, J. Polymer Sci. 10 (1953) 291-318: the energy release rate is
G = -(dPi/da)/h at fixed grips, so that two legs pulled apart tear a sheet at F*(lambda + 1)/2*(cos psi1 + cos psi2) = Gc*h if a leg
stores F*(lambda - 1)/2 per length (law linear in the stretch).
Law, from its definition: W = h*A*(1/2)*eps:C:eps with eps = U - 1, F = R*U, isotropic plane stress. With singular values s1 >= s2 of F
(3x2) and t = s1 + s2 = sqrt(|F|^2 + 2|f1 x f2|):  W = h*A*(E/(1 - nu^2))/2*(nu*(t - 2)^2 + (1 - nu)*(|F|^2 - 2t + 2)).
A membrane alone has slack parts without stiffness, in which Newton's method crawls. The plate stiffness kb*E*h^3/12/(1 - nu^2) is added by the
quadratic form of M. Bergou et al. (A quadratic bending model for inextensible surfaces, SGP 2006); kb = 1 is that of the material. In a steady
tear it moves along with the tip and stores the same at any length: the pull must not depend on kb: the last two rows of the table.
Sheet: [-W/2, W/2] x [0, L], cut along x = 0 from y = L, triangles with alternating diagonals, mirror images about the tear, columns
coarser for |x| > 2. Grips: nodes with y = L and 0 < |x| <= 1.5; they keep x and y, and stand at z = +s and -s. The rest is free.
Units mm, N, MPa.   Run: python trouser.py > trouser.csv   (numpy and scipy; half a minute of one core)
"""
import os
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
import numpy as np, scipy.sparse as sp
from scipy.linalg import cholesky_banded, cho_solve_banded

# Specimens of `rhexis verify tear-trouser` and `tear-hand-force`.
TROUSER = dict(W=12., L=30., leg=12., h=.1, nu=.3, gc=.05)
HAND = dict(W=8., L=16., leg=6., h=.05, nu=.4, gc=.1)
HELD = 1.5


class Sheet:
    def __init__(s, case, E, e, kb=1.):
        s.E, s.e, s.kb = E, e, kb
        s.__dict__.update(case)
        half = [0.]
        while half[-1] < s.W/2 - 1e-9:
            half.append(half[-1] + (e if half[-1] < 2 - 1e-9 else min(1.5*(half[-1] - half[-2]), 1.)))
        half = np.array(half)
        fine = half <= 2 + 1e-9
        half[~fine] = 2 + (half[~fine] - 2)*(s.W/2 - 2)/(half[-1] - 2)
        xs, ys = np.r_[-half[:0:-1], half], np.arange(round(s.L/e) + 1)*e
        nx, c = len(xs), len(half) - 1
        X = np.array([(x, y) for y in ys for x in xs])
        T = []
        for j in range(len(ys) - 1):
            for i in range(nx - 1):
                a = j*nx + i
                b, u, v = a + 1, a + nx, a + nx + 1
                up = (min(i, nx - 2 - i) + j + (i >= c)) % 2 == 0
                T += [[a, b, v], [a, v, u]] if up else [[a, b, u], [b, v, u]]
        s.T = np.array(T)
        s.line, s.n0 = np.arange(len(ys))*nx + c, len(X)
        s.X = np.r_[X, X[s.line]]                       # copies of the line's nodes: the right lip
        s.right = X[s.T].mean(1)[:, 0] > 0
        D = X[s.T]
        D = np.stack([D[:, 1] - D[:, 0], D[:, 2] - D[:, 0]], 2)
        s.area, Bi = np.linalg.det(D)/2, np.linalg.inv(D)
        s.N = np.concatenate([-Bi.sum(1, keepdims=True), Bi], 1)      # gradients of the shape functions
        s.B = np.einsum('tak,ij->tkiaj', s.N, np.eye(3)).reshape(-1, 6, 9)
        top = abs(X[:, 1] - s.L) < 1e-9
        s.grips = [np.where(top & (w*X[:, 0] > 1e-9) & (w*X[:, 0] <= HELD + 1e-9))[0] for w in (-1, 1)]
        s.row = round((s.L - s.leg)/e)                   # of the end of the cut

    def cut(s, torn):
        """Opens the line down to `torn` edges below the end of the cut; sets up the reduced unknowns: free nodes, then s."""
        s.tip = s.row - torn
        copy = np.arange(len(s.X))
        copy[s.line[s.tip + 1:]] = s.n0 + np.arange(s.tip + 1, len(s.line))
        s.now = s.T.copy()
        s.now[s.right] = copy[s.T[s.right]]
        n, grip = len(s.X), np.concatenate(s.grips)
        free = np.setdiff1d(s.now, grip)
        free = free[np.lexsort((s.X[free, 0], s.X[free, 1]))]                    # row by row: a narrow band
        m, z = 3*len(free), 3*grip + 2
        col, sign = np.full(3*n, -1), np.ones(3*n)
        col[(3*free[:, None] + np.arange(3)).ravel()], col[z] = np.arange(m), m
        sign[z] = np.where(s.X[grip, 0] < 0, 1., -1.)
        dof = np.where(col >= 0)[0]
        s.Z = sp.csr_matrix((sign[dof], (dof, col[dof])), (3*n, m + 1))
        s.at = (3*s.now[:, :, None] + np.arange(3)).reshape(-1, 9)
        i, j = np.broadcast_arrays(col[s.at][:, :, None], col[s.at][:, None])
        s.low = (i >= j) & (j >= 0)                                              # entries of the lower half of the band
        s.sign = (sign[s.at][:, :, None]*sign[s.at][:, None])[s.low]
        s.ij = i[s.low], j[s.low]
        edges = {}
        for t, tri in enumerate(s.now):
            for k in range(3):
                p, q, o = tri[k], tri[(k + 1) % 3], tri[(k + 2) % 3]
                edges.setdefault((min(p, q), max(p, q)), []).append((o, t))
        pairs = np.array([(p, q, f[0][0], f[1][0], f[0][1], f[1][1]) for (p, q), f in edges.items() if len(f) == 2])
        p, q, o, r, t, u = pairs.T
        cot = lambda at, i, k: ((s.X[i] - s.X[at])*(s.X[k] - s.X[at])).sum(1)/(2*s.area[t if k is o else u])
        c = [cot(p, q, o), cot(q, p, o), cot(p, q, r), cot(q, p, r)]
        w = np.sqrt(s.kb*s.E*s.h**3/12/(1 - s.nu**2)*3/(s.area[t] + s.area[u]))
        val = w*np.array([c[1] + c[3], c[0] + c[2], -(c[0] + c[1]), -(c[2] + c[3])])
        M = sp.csr_matrix((val.ravel(), (np.tile(np.arange(len(p)), 4), pairs[:, :4].T.ravel())), (len(p), n))
        s.bend = sp.kron(M.T@M, sp.identity(3)).tocsr()
        K = sp.tril(s.Z.T@s.bend@s.Z).tocoo()
        s.band = np.concatenate([K.row - K.col, s.ij[0] - s.ij[1]]).max() + 1
        s.slot = (s.ij[0] - s.ij[1])*(m + 1) + s.ij[1]
        s.stiff = np.zeros((s.band, m + 1))
        s.stiff[K.row - K.col, K.col] = K.data

    def energy(s, x, order=0):
        """Energy; with order 1 its gradient as well; with 2 the band of the Hessian made semidefinite by triangle; 3 the exact one."""
        F = np.einsum('tai,tak->tik', x[s.now], s.N)
        f1, f2 = F[:, :, 0], F[:, :, 1]
        angle = np.arctan2(2*(f1*f2).sum(1), (f1*f1 - f2*f2).sum(1))/2
        v = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])        # right singular vectors
        u = [f1*v[i, 0][:, None] + f2*v[i, 1][:, None] for i in (0, 1)]
        S = np.sqrt([(w*w).sum(1) for w in u]) + 1e-300                                       # singular values
        eps, V, Q, fb = S - 1, s.area*s.h, s.E/(1 - s.nu**2), s.bend@x.ravel()
        T = Q*(eps + s.nu*eps[::-1])                                                          # principal Biot stresses
        e = (V*(T*eps).sum(0)).sum()/2 + fb@x.ravel()/2
        if order == 0:
            return e
        u = [w/S[i][:, None] for i, w in enumerate(u)]
        mode = lambda a, i: (a[:, None]*v[i].T[:, :, None]).reshape(-1, 6)                    # a x v_i as (f1, f2)
        m1, m2 = mode(u[0], 0), mode(u[1], 1)
        grad = np.einsum('t,tki,tk->ti', V, s.B, T[0][:, None]*m1 + T[1][:, None]*m2)
        grad = np.bincount(s.at.ravel(), grad.ravel(), x.size) + fb
        if order == 1:
            return e, grad
        n, w1, w2 = np.cross(u[0], u[1]), mode(u[1], 0), mode(u[0], 1)
        modes = np.stack([(m1 + m2)/2**.5, (m1 - m2)/2**.5, (w1 + w2)/2**.5, (w1 - w2)/2**.5, mode(n, 0), mode(n, 1)], 1)
        soft, one = Q*(1 - s.nu), np.ones(len(V))
        k = np.array([Q*(1 + s.nu)*one, soft*one, soft*one, (T[0] + T[1])/(S[0] + S[1]), T[0]/S[0], T[1]/S[1]]).T
        k = V[:, None]*(np.maximum(k, 0) if order == 2 else k)                                # eigenvalues of d2W/dF2
        MB = modes@s.B
        H = MB.transpose(0, 2, 1)@(k[:, :, None]*MB)
        return e, grad, np.bincount(s.slot, s.sign*H[s.low], s.stiff.size).reshape(s.stiff.shape) + s.stiff

    def solve(s, x, load, most=150, tol=1e-7):
        """Equilibrium at a pull of a leg [N], to a force of `tol` [N] at every node. Levenberg's damping, projected Hessian.
        Gives positions and energy Pi."""
        x = x.copy()
        z0, dead = s.grips[0][0], 2*load
        b = np.zeros(s.Z.shape[1])
        b[-1] = dead
        mu, least = 1e-5*s.E*s.h, 1e-10*s.E*s.h
        for _ in range(most):
            e, grad, K = s.energy(x, 2)
            r = s.Z.T@grad - b
            if abs(r).max() < tol:
                return x, e
            f = e - dead*x[z0, 2]
            while True:
                A = K.copy()
                A[0] += mu
                q = -cho_solve_banded((cholesky_banded(A, True, lower=True, check_finite=False), True), r)
                y, gain = x + (s.Z@q).reshape(-1, 3), -(r@q)/2
                rho = (f - s.energy(y) + dead*y[z0, 2])/gain
                if rho > .01 or gain < 1e-12*abs(f):
                    break
                mu *= 5
            x, mu = y, max(mu/5, least) if rho > .5 else mu
        raise SystemExit(f'no equilibrium in {most} iterations: {abs(r).max():.1e} N left')

    def folded(s):
        """Start: legs folded by right angles at the tip, up and down, without strain but for a little noise."""
        y0 = s.e*s.tip
        up, side = np.maximum(s.X[:, 1] - y0, 0), np.where(s.X[:, 0] < -1e-9, 1., -1.)
        side[s.line] = 1.
        x = np.c_[s.X[:, 0], np.minimum(s.X[:, 1], y0), side*up]
        noise = 1e-3*s.e*np.random.default_rng(1).standard_normal(x.shape)
        noise[np.concatenate(s.grips)] = 0
        return x + noise


def static(case, E, e, kb, torn=4., over=2.):
    """The pull at which G over `over` mm of tear from `torn` mm on is the toughness, over Gc*h/2; G/Gc over one edge, from and to; nodes."""
    s, n, m = Sheet(case, E, e, kb), round(torn/e), round(over/e)
    s.cut(n)
    F, x, V = case['gc']*case['h']/2, s.folded(), np.zeros(m + 1)
    kept = [None]*(m + 1)
    for turn in range(3):
        for i in range(m + 1):
            s.cut(n + i)
            if turn == 0 and i:
                x[s.n0 + s.tip + 1] = x[s.line[s.tip + 1]]
            x, pi = s.solve(x if turn == 0 else kept[i], F)
            kept[i], V[i] = x, pi - 2*F*x[s.grips[0][0], 2]
        G = -np.diff(V)/(s.h*e)
        if turn < 2:
            F *= case['gc']/G.mean()
    return F/(s.gc*s.h/2), G.min()/s.gc, G.max()/s.gc, len(s.X)


def check(E, e):
    """Errors of gradient and Hessian against central differences, at a rough state."""
    s, rng, d = Sheet(TROUSER, E, e), np.random.default_rng(2), 1e-6
    s.cut(2)
    x = s.folded()
    x += .1*e*rng.standard_normal(x.shape)
    q = rng.standard_normal(s.Z.shape[1])
    D = (s.Z@q).reshape(-1, 3)
    _, g, K = s.energy(x, 3)
    Kq = K[0]*q
    for i in range(1, len(K)):
        Kq[i:] += K[i, :-i]*q[:-i]
        Kq[:-i] += K[i, :-i]*q[i:]
    num = s.Z.T@(s.energy(x + d*D, 1)[1] - s.energy(x - d*D, 1)[1])/2/d
    return abs((s.energy(x + d*D) - s.energy(x - d*D))/2/d/(g@D.ravel()) - 1), np.linalg.norm(num - Kq)/np.linalg.norm(Kq)


if __name__ == '__main__':
    print('# Trouser tear of thin sheets by trouser.py: the pull of a leg at which G is the toughness over 2 mm of tear.')
    print('# Gradient and Hessian off central differences: %.0e, %.0e.' % check(1., .5))
    print('# sheet: 0 is 12 x 30 mm, 1 is 8 x 16 mm; bending: plate stiffness over that of the material; pull over Gc*h/2;')
    print('# least, most: G/Gc over one edge.')
    print('sheet,young_MPa,edge_mm,bending,pull,least,most,nodes')
    rows = [(sheet, E, e, 1.) for sheet, moduli in enumerate(((1., .1), (2., .2))) for E in moduli for e in (1., .5, .25)]
    for sheet, E, e, kb in rows + [(0, 1., .5, 3.), (0, 1., .5, .3)]:
        pull, least, most, nodes = static((TROUSER, HAND)[sheet], E, e, kb)
        print(f'{sheet},{E:g},{e:g},{kb:g},{pull:.4f},{least:.4f},{most:.4f},{nodes}', flush=True)
