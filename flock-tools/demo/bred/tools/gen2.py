import sys,random,copy,math,breed
from big import load
name,seed,sec=sys.argv[1],int(sys.argv[2]),float(sys.argv[3]); par=[load(x) for x in sys.argv[4:]]
def fixcolor(g,r):
    n=len(g['x'])
def make(r,i):
    a=copy.deepcopy(r.choice(par)); b=copy.deepcopy(r.choice(par)); g=a
    how=r.random()
    if how<.4:   # cross: transforms of both
        xs=[x for x in a['x'] if r.random()<.65]+[x for x in b['x'] if r.random()<.65]; r.shuffle(xs); xs=xs[:5]
        if len(xs)<2: xs=a['x'][:1]+b['x'][:2]
        g['x']=xs; g.pop('chaos',None)
        if r.random()<.5:
            g.pop('fin',None)
            if 'fin' in b: g['fin']=b['fin']
        g['sym']=r.choice([a['sym'],b['sym'],1]); 
    k=r.choice([.08,.2,.35]) if how>=.4 else .1
    for x in g['x']:
        x['coefs']=[round(c+r.gauss(0,k),6) for c in x['coefs']]
        if r.random()<.3: x['weight']=round(min(8,max(.2,x['weight']*math.exp(r.gauss(0,.5)))),6)
    if how>=.4:
        u=r.random(); n=len(g['x'])
        if u<.3: d=breed.draw(r)['x'][0]; j=r.randrange(n); d['color']=g['x'][j]['color']; g['x'][j]=d
        elif u<.5 and n<6: g['x'].append(breed.draw(r)['x'][0]); g.pop('chaos',None)
        elif u<.7:
            j=r.randrange(n); x=g['x'][j]; x['vars']=breed.vars_(r,breed.SOFT)
    if r.random()<.3:
        if 'fin' in g and r.random()<.4: g.pop('fin')
        else:
            f=r.choice(breed.FINAL); g['fin']=dict(vars={f:1.0,**breed.params(r,f)},coefs=breed.affine(r,.6,1.3,.5,.05))
            if f in('julian','juliascope'): g['fin']['vars'][f+'_dist']=1
    if r.random()<.15: g['sym']=r.choice([1,2,3,4,5,6])
    if r.random()<.7: g['pal']=breed.newpal(r)
    n=len(g['x']); cs=[min(1,max(0,(j+r.uniform(-.2,.2))/max(1,n-1))) for j in range(n)]; r.shuffle(cs)
    if r.random()<.6:
        for x,c in zip(g['x'],cs): x['color']=round(c,6)
    g['cam']=[0,0,3.2]; g['b']=6.; g['kind']='2'; g.pop('score',0); g.pop('stat',0); return g
breed.run(name,seed,100000,make,sec)
