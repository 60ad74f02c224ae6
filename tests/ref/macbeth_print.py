# Readings of a printer of known colours, for macbethcal: P3 primaries on equal-energy white, light = 0.01 + 0.99 v^1.1 of
# the picture value v it is sent. The patches are macbethcal's own (Radiance, src/px/macbethcal.c).
MB = """.421236 .361196 .103392 .40868 .358157 .352867 .265063 .271424 .185124 .362851 .43055 .132625 .28888 .260851 .233138
.277642 .365326 .416443 .524965 .40068 .312039 .225018 .190392 .114999 .487199 .315372 .198616 .314245 .227231 .0646047
.396202 .489732 .440724 .493297 .435299 .43444 .198191 .149265 .0588122 .322838 .487601 .229258 .561833 .321165 .126978
.468113 .467021 .605289 .397128 .248535 .201761 .209552 .276256 .190917 .337219 .339042 .912482 .333283 .335077 .588297
.332747 .334371 .3594 .331925 .334202 .19114 .330408 .332615 .0892964 .331841 .331405 .0319541"""
def inverse(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    k = a*(e*i - f*h) - b*(d*i - f*g) + c*(d*h - e*g)
    return [[(e*i-f*h)/k, (c*h-b*i)/k, (b*f-c*e)/k], [(f*g-d*i)/k, (a*i-c*g)/k, (c*d-a*f)/k],
            [(d*h-e*g)/k, (b*g-a*h)/k, (a*e-b*d)/k]]
def apply(m, v): return [sum(p*q for p, q in zip(row, v)) for row in m]
def matrix(primaries):
    m = [list(row) for row in zip(*[(x, y, 1 - x - y) for x, y in primaries])]
    s = apply(inverse(m), [1, 1, 1])
    return [[p*q for p, q in zip(row, s)] for row in m]
if __name__ == "__main__":
    standard = inverse(matrix([(.64, .33), (.29, .60), (.15, .06)]))
    printer = matrix([(.68, .32), (.265, .69), (.15, .06)])
    n = list(map(float, MB.split()))
    print("0 0.3333333 0.3333333 1")
    for i in range(24):
        x, y, Y = n[3*i:3*i+3]
        sent = apply(standard, [x*Y/y, Y, (1-x-y)*Y/y])
        X = apply(printer, [0.01 + 0.99*min(max(v, 0), 1)**1.1 for v in sent])
        print(i + 1, *["%.6f" % v for v in (X[0]/sum(X), X[1]/sum(X), X[1])])
