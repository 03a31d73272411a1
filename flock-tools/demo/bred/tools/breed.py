# The breeder: random genomes, framed and exposed by measuring, scored, kept as JSON. Everything from random numbers.
import random, math, json, os, subprocess, sys, copy
import numpy as np
from PIL import Image
D='/root/breed'
# ---------- palettes: Oklab ramps, stops (position, L, C, hue in degrees), cyclic ----------
def oklch(L,C,h):
    a,b=C*math.cos(math.radians(h)),C*math.sin(math.radians(h))
    l=(L+0.3963377774*a+0.2158037573*b)**3;m=(L-0.1055613458*a-0.0638541728*b)**3;s=(L-0.0894841775*a-1.2914855480*b)**3
    return np.array([4.0767416621*l-3.3077115913*m+0.2309699292*s,-1.2684380046*l+2.6097574011*m-0.3413193965*s,-0.0041960863*l-0.7034186147*m+1.7076147010*s])
def srgb(L,C,h):
    while True:
        lin=oklch(L,C,h)
        if C<=0 or (lin.min()>-1e-4 and lin.max()<1.0001): break
        C=max(0,C-0.004)
    lin=np.clip(lin,0,1); v=np.where(lin<=0.0031308,12.92*lin,1.055*lin**(1/2.4)-0.055)
    return [int(round(255*x)) for x in np.clip(v,0,1)]
PAL={
 # name: stops
 'emberteal':[(0,.42,.16,25),(.18,.62,.20,40),(.32,.90,.12,85),(.45,.50,.10,40),(.6,.40,.09,205),(.75,.68,.13,195),(.87,.92,.06,180),(.95,.45,.12,300)],
 'peacock':[(0,.38,.14,265),(.2,.55,.16,240),(.38,.72,.14,195),(.5,.86,.17,145),(.62,.93,.12,100),(.74,.55,.12,160),(.88,.38,.14,300)],
 'dusk':[(0,.36,.16,285),(.22,.50,.22,310),(.4,.66,.22,0),(.55,.78,.16,50),(.66,.94,.07,85),(.78,.55,.17,15),(.9,.38,.14,270)],
 'iceglow':[(0,.36,.14,262),(.25,.52,.17,252),(.45,.75,.12,225),(.58,.95,.04,200),(.7,.70,.10,220),(.82,.50,.16,285),(.92,.62,.20,330)],
 'goldink':[(0,.36,.11,265),(.2,.42,.12,275),(.35,.50,.09,60),(.5,.70,.14,75),(.62,.92,.10,92),(.74,.66,.15,60),(.86,.42,.13,25)],
 'fern':[(0,.36,.09,165),(.2,.50,.13,150),(.36,.70,.19,135),(.5,.90,.15,115),(.62,.80,.13,85),(.75,.50,.12,45),(.88,.38,.10,200)],
 'rosewood':[(0,.38,.13,15),(.2,.52,.19,12),(.38,.70,.17,5),(.52,.88,.08,20),(.64,.75,.10,70),(.78,.46,.08,150),(.9,.36,.09,330)],
 'aurora':[(0,.36,.14,285),(.16,.48,.18,290),(.32,.60,.14,220),(.48,.78,.17,165),(.6,.92,.15,130),(.74,.60,.14,190),(.88,.50,.22,330)],
 'copperverd':[(0,.40,.11,45),(.2,.60,.14,50),(.34,.82,.11,65),(.46,.94,.05,80),(.58,.62,.10,180),(.74,.45,.09,195),(.88,.38,.10,30)],
 'violetlime':[(0,.36,.17,295),(.22,.52,.23,300),(.4,.72,.15,305),(.52,.92,.06,320),(.64,.86,.18,120),(.76,.56,.14,140),(.9,.38,.12,250)],
 'lapisrose':[(0,.36,.18,265),(.2,.50,.21,262),(.36,.68,.13,240),(.5,.90,.05,220),(.62,.78,.14,355),(.76,.60,.21,0),(.9,.40,.16,320)],
 'honey':[(0,.38,.10,35),(.22,.56,.15,45),(.42,.76,.16,70),(.56,.95,.08,95),(.7,.80,.07,200),(.84,.50,.09,235),(.93,.38,.09,300)],
 'flamingo':[(0,.40,.17,345),(.2,.62,.23,355),(.38,.78,.15,15),(.5,.94,.05,50),(.64,.72,.13,190),(.8,.48,.11,210),(.92,.37,.14,290)],
 'deepsea':[(0,.34,.11,240),(.2,.46,.12,225),(.4,.64,.12,200),(.55,.86,.12,175),(.66,.95,.06,120),(.76,.74,.18,55),(.86,.52,.18,35),(.94,.36,.12,285)],
 'opal':[(0,.40,.10,270),(.18,.66,.11,300),(.34,.86,.07,350),(.5,.94,.06,80),(.66,.84,.09,165),(.82,.62,.11,225)],
 'wine':[(0,.35,.13,5),(.2,.44,.17,350),(.38,.58,.20,335),(.52,.74,.15,300),(.64,.92,.05,280),(.76,.80,.13,80),(.88,.50,.13,40)],
 'saffronblue':[(0,.38,.15,262),(.25,.58,.17,255),(.42,.85,.07,230),(.5,.96,.03,100),(.6,.84,.15,80),(.76,.64,.18,52),(.9,.42,.14,20)],
 'jade':[(0,.34,.08,185),(.22,.52,.11,175),(.42,.74,.14,165),(.56,.94,.07,150),(.7,.74,.11,280),(.84,.50,.19,295),(.93,.38,.12,240)],
}
def palette(name,shift=0.0,ripple=0.0,flip=False,hue=0.0):
    st=PAL[name]; ps=np.array([s[0] for s in st]+[1.0]); L=[s[1] for s in st]; ab=[(s[2]*math.cos(math.radians(s[3]+hue)),s[2]*math.sin(math.radians(s[3]+hue))) for s in st]
    L=np.array(L+L[:1]); A=np.array([x[0] for x in ab]+[ab[0][0]]); B=np.array([x[1] for x in ab]+[ab[0][1]])
    out=[]
    for i in range(256):
        t=((255-i if flip else i)/256+shift)%1; k=max(0,min(len(ps)-2,int(np.searchsorted(ps,t,'right'))-1)); u=(t-ps[k])/(ps[k+1]-ps[k]); u=u*u*(3-2*u)
        l,a,b=[v[k]*(1-u)+v[k+1]*u for v in (L,A,B)]
        l=l*(1+ripple*math.sin(2*math.pi*12*i/256)); out.append(srgb(min(l,.97),math.hypot(a,b),math.degrees(math.atan2(b,a))))
    return out
# ---------- variations with parameters ----------
U=random.uniform
def I(r,*xs): return r.choice(xs)
def params(r,n):
    u=r.uniform
    P={'blob':lambda:dict(low=u(.2,.7),high=u(.8,1.3),waves=r.randint(2,9)),
     'pdj':lambda:dict(a=u(-2.5,2.5),b=u(-2.5,2.5),c=u(-2.5,2.5),d=u(-2.5,2.5)),
     'fan2':lambda:dict(x=u(-1,1),y=u(-2,2)),'rings2':lambda:dict(val=u(.2,1.3)),
     'perspective':lambda:dict(angle=u(.1,.9),dist=u(1,3)),
     'julian':lambda:dict(power=I(r,2,2,3,3,-2,-3,4,-4,5,6,-6,8,-8,12,-12),dist=I(r,1,1,1,u(.5,1.4),-1)),
     'juliascope':lambda:dict(power=I(r,2,2,3,3,-2,-3,4,-4,5,6,-6,8),dist=I(r,1,1,1,u(.5,1.4),-1)),
     'curl':lambda:dict(c1=u(-.6,.6),c2=u(-.5,.5)),'rectangles':lambda:dict(x=u(.2,1),y=u(.2,1)),
     'ngon':lambda:dict(power=u(1,4),sides=r.randint(3,8),corners=u(.3,2),circle=u(.3,1.5)),
     'disc2':lambda:dict(rot=u(-2,2),twist=u(-3,3)),
     'super_shape':lambda:dict(rnd=u(0,.6),m=r.randint(2,9),n1=u(.5,4),n2=u(.5,4),n3=u(.5,4),holes=u(-.5,.3)),
     'flower':lambda:dict(holes=u(-.3,.4),petals=r.randint(3,9)),'conic':lambda:dict(holes=u(-.2,.2),eccentricity=u(.3,1.5)),
     'parabola':lambda:dict(height=u(.3,1),width=u(.3,1)),'bent2':lambda:dict(x=u(.4,1.5),y=u(.4,1.5)),
     'bipolar':lambda:dict(shift=u(-1,1)),'cell':lambda:dict(size=u(.2,.8)),
     'cpow':lambda:dict(r=u(.4,1.2),i=u(-.5,.5),power=r.randint(1,6)),
     'curve':lambda:dict(xamp=u(-1,1),yamp=u(-1,1),xlength=u(.3,1.5),ylength=u(.3,1.5)),
     'escher':lambda:dict(beta=u(-1.2,1.2)),'lazysusan':lambda:dict(spin=u(-3,3),space=u(-.6,.6),twist=u(-1.2,1.2),x=u(-.3,.3),y=u(-.3,.3)),
     'modulus':lambda:dict(x=u(.5,1.5),y=u(.5,1.5)),'oscilloscope':lambda:dict(separation=u(.2,1),frequency=u(2,6),amplitude=u(.3,1),damping=u(0,1)),
     'popcorn2':lambda:dict(x=u(-.4,.4),y=u(-.4,.4),c=u(1,5)),'separation':lambda:dict(x=u(0,.6),xinside=u(-.5,.5),y=u(0,.6),yinside=u(-.5,.5)),
     'split':lambda:dict(xsize=u(.3,1.2),ysize=u(.3,1.2)),'splits':lambda:dict(x=u(-.7,.7),y=u(-.7,.7)),'stripes':lambda:dict(space=u(-.5,.5),warp=u(-.6,.6)),
     'wedge':lambda:dict(angle=u(0,2),hole=u(-.3,.3),count=r.randint(1,6),swirl=u(-.6,.6)),
     'wedge_julia':lambda:dict(angle=u(0,1.2),count=r.randint(1,6),power=I(r,2,3,-2,-3,4,6,-5),dist=u(.6,1.2)),
     'wedge_sph':lambda:dict(angle=u(0,2),hole=u(-.3,.3),count=r.randint(1,6),swirl=u(-.6,.6)),
     'whorl':lambda:dict(inside=u(-1.5,1.5),outside=u(-1,1)),'waves2':lambda:dict(scalex=u(-.3,.3),scaley=u(-.3,.3),freqx=u(1,5),freqy=u(1,5)),
     'auger':lambda:dict(freq=u(1,5),weight=u(.1,.6),sym=u(0,1),scale=u(.1,1)),'flux':lambda:dict(spread=u(-1,1)),
     'mobius':lambda:dict(re_a=u(-1,1),im_a=u(-1,1),re_b=u(-1,1),im_b=u(-1,1),re_c=u(-1,1),im_c=u(-1,1),re_d=u(-1,1),im_d=u(-1,1)),
     'pie':lambda:dict(slices=r.randint(3,9),rotation=u(0,6),thickness=u(.2,.7)),'radial_blur':lambda:dict(angle=u(0,1))}
    return {f'{n}_{k}':round(v,6) for k,v in P[n]().items()} if n in P else {}
SOFT='linear linear linear sinusoidal spherical swirl horseshoe handkerchief julia bent2 waves fisheye popcorn exponential eyefish bubble julian juliascope curl disc2 elliptic edisc loonie bipolar escher foci lazysusan popcorn2 polar2 scry splits stripes wedge whorl waves2 log auger flux mobius cpow ex heart disc spiral hyperbolic diamond polar power cosine rings2 fan2 blob pdj cylinder curve butterfly separation wedge_julia wedge_sph sin cos tan sinh cosh tanh sech csch coth cross secant2 ngon exp bent split'.split()
KIND={'grand':['julian','juliascope','julian','julia','wedge_julia','cpow'],
 'orb':['loonie','bubble','fisheye','spherical','julian','mobius','edisc','eyefish'],
 'silk':['elliptic','splits','bipolar','foci','edisc','curl','escher','log','polar2','disc2'],
 'swirl':['swirl','spherical','whorl','lazysusan','curl','escher','spiral','cpow','handkerchief','flux','auger'],
 'web':['spherical','mobius','wedge_sph','curl','bent2','popcorn2','waves2','hyperbolic','cross','scry']}
FINAL='julian julian juliascope spherical bubble eyefish fisheye polar2 elliptic edisc scry foci bipolar curl mobius loonie swirl disc2 lazysusan wedge log escher linear cpow whorl'.split()
def affine(r,lo,hi,off,skew=.25):
    s=r.uniform(lo,hi); t=r.uniform(0,2*math.pi); k=1+r.uniform(-skew,skew); w=r.uniform(-skew,skew)
    a,d=s*math.cos(t),s*math.sin(t); b,e=-s*k*math.sin(t+w),s*k*math.cos(t+w)
    return [round(x,6) for x in (a,d,b,e,r.uniform(-off,off),r.uniform(-off,off))]
def vars_(r,pool,nmax=2):
    n=1 if r.random()<.62 else nmax; v={}
    ws=[1.0] if n==1 else [r.uniform(.25,.75)]; ws+= [1-ws[0]]*(n-1)
    for w in ws:
        k=r.choice(pool); v[k]=round(w*r.uniform(.85,1.15),6); v.update(params(r,k))
    return v
def draw(r,kind=None):
    kind=kind or r.choice(list(KIND)+['any'])
    pool=SOFT if kind=='any' else KIND[kind]
    n=r.choice([2,2,3,3,3,4,4,5,6]) ; xs=[]
    sym=r.choice([2,3,3,4,5,6,7,8]) if r.random()<.2 else 1
    if sym>1: n=min(n,3)
    for i in range(n):
        if kind!='any' and i>0 and r.random()<.45: v=vars_(r,['linear','linear']+SOFT,2)
        else: v=vars_(r,pool)
        strong=any(k in v for k in('julian','juliascope','julia','wedge_julia','cpow'))
        x=dict(weight=round(r.uniform(.3,2.2) if not(strong and r.random()<.5) else r.uniform(2,6),6),color=0,vars=v,
          coefs=affine(r,.35,1.15 if strong or r.random()<.4 else .9,1.0,r.choice([0,.1,.35])))
        if r.random()<.22: x['post']=affine(r,.5,1.3,.6,.1)
        x['color_speed']=r.choice([.5,.5,.5,.35,.65]); xs.append(x)
    cs=[(i+r.uniform(-.2,.2))/max(1,n-1) for i in range(n)]; r.shuffle(cs)
    for x,c in zip(xs,cs): x['color']=round(min(1,max(0,c)),6)
    g=dict(kind=kind,x=xs,sym=sym,pal=newpal(r))
    if n>=3 and r.random()<.3:
        g['chaos']=[[round(r.choice([0,.15,.5,1,1,1,2,1]),3) for _ in range(n)] for _ in range(n)]
        for i,row in enumerate(g['chaos']):
            if sum(row)<=.2: row[(i+1)%n]=1
    if r.random()<.4:
        k=r.choice(FINAL); g['fin']=dict(vars={k:1.0,**params(r,k)},coefs=affine(r,.6,1.3,.5,.05))
        if k in('julian','juliascope') : g['fin']['vars'][k+'_dist']=1
    g['cam']=[0,0,3.2]  # centre, half width
    g['b']=6.0; g['gamma']=2.5
    return g
def newpal(r): return [r.choice(list(PAL)),round(r.random(),4),r.choice([0,0,0,.1,.18]),r.random()<.5,r.choice([0,0,r.uniform(-14,14)])]
def xml(g,name,w=1280,h=720,comment='bred from a random start; licence MIT OR Apache-2.0'):
    cx,cy,hw=g['cam']; att=lambda v:' '.join(f'{k}="{x:g}"' if isinstance(x,int) else f'{k}="{round(x,6)}"' for k,x in v.items())
    num=lambda c:' '.join(f'{x:.6f}'.rstrip('0').rstrip('.') for x in c)
    s=f'<flame name="{name}" time="0" size="{w} {h}" center="{round(cx,6)} {round(cy,6)}" scale="{w/(2*hw):.6f}" rotate="{g.get("rot",0)}" supersample="2" filter="0.9" quality="400" temporal_samples="64" background="{g.get("bg","0 0 0")}" brightness="{g["b"]:.6g}" gamma="{g["gamma"]}" gamma_threshold="{g.get("gt",.015)}" vibrancy="{g.get("vib",1)}" highlight_power="1" estimator_radius="6" estimator_minimum="0" estimator_curve="0.5" palette_mode="linear" interpolation_type="log" nick="dreams" comment="{comment}">\n'
    for i,x in enumerate(g['x']):
        ch=f' chaos="{num(g["chaos"][i]+[1]*(g["sym"]-1))}"' if 'chaos' in g else ''
        po=f' post="{num(x["post"])}"' if 'post' in x else ''
        s+=f'   <xform weight="{x["weight"]}" color="{x["color"]}" color_speed="{x["color_speed"]}" animate="{x.get("animate",1)}" {att(x["vars"])} coefs="{num(x["coefs"])}"{po}{ch}/>\n'
    for k in range(1,g['sym']):
        t=2*math.pi*k/g['sym']; c,d=math.cos(t),math.sin(t)
        s+=f'   <xform weight="1" color="0" color_speed="0" animate="0" linear="1" coefs="{num([c,d,-d,c,0,0])}"/>\n'
    if 'fin' in g: s+=f'   <finalxform color="0" color_speed="0" animate="0" {att(g["fin"]["vars"])} coefs="{num(g["fin"]["coefs"])}"/>\n'
    p=palette(*g['pal']); s+='   <palette count="256" format="RGB">\n'
    for i in range(0,256,8): s+='      '+''.join('%02X%02X%02X'%tuple(c) for c in p[i:i+8])+'\n'
    return s+'   </palette>\n</flame>\n'
def render(g,out,size=(160,90),spp=20,extra=()):
    f=f'{D}/tmp/{os.getpid()}.flam3'; open(f,'w').write(xml(g,'x'))
    p=subprocess.run(['nice','-n','10',D+'/dreams','still',f,'--size','%dx%d'%size,'--spp',str(spp),'--threads','1','--supersample','1','--out',out,*extra],capture_output=True,text=True)
    if p.returncode: return None
    return np.asarray(Image.open(out).convert('RGB')).astype(float)/255
LW=np.array([.2126,.7152,.0722])
def frame(g,tmp):
    """centre and scale from the lit box of coarse pictures"""
    for it in range(3):
        im=render(g,tmp,(128,128),8) if it==0 else render(g,tmp,(128,72),10)
        if im is None: return False
        l=(im@LW); l=np.minimum(l,.6); H,W=l.shape
        if it==0: hw=g['cam'][2]; hh=hw
        else: hw=g['cam'][2]; hh=hw*H/W
        if l.mean()<.004:
            g['b']*=6; continue
        l=np.where(l>.05,l,0); t=l.sum()
        if t<=0: g['b']*=6; continue
        def q(a,p): c=np.cumsum(a)/a.sum(); return [np.interp(x,c,np.arange(len(a))+.5)/len(a)*2-1 for x in p]
        x0,x1=q(l.sum(0),(.04,.96)); y0,y1=q(l.sum(1),(.04,.96))
        cx,cy=(x0+x1)/2*hw,(y0+y1)/2*hh
        need=max((x1-x0)/2*hw, (y1-y0)/2*hh*1.15)*1.04   # cover the width or 15:9 of the height
        g['cam']=[g['cam'][0]+cx,g['cam'][1]+cy,min(max(need,.02),12)]
        if it==0 and (x1-x0)<1.2: pass
    return True
def expose(g,tmp,size=(160,90),spp=20,want=.17):
    im=None
    for it in range(3):
        im=render(g,tmp,size,spp)
        if im is None: return None
        m=(im@LW).mean()
        if m<=.0005: g['b']*=30; continue
        f=(want/m)**2.0; f=min(max(f,.02),40)
        if .72<want/m<1.35: break
        g['b']=min(max(g['b']*f,.02),4000)
    return im
def blur(l,k):
    for ax in (0,1):
        p=np.pad(l,[(k,k) if a==ax else (0,0) for a in(0,1)],'edge'); c=np.cumsum(p,ax); z=np.zeros_like(np.take(c,[0],ax)); c=np.concatenate([z,c],ax)
        n=2*k+1; l=(np.take(c,range(n,c.shape[ax]),ax)-np.take(c,range(0,c.shape[ax]-n),ax))/n
    return l
def score(im):
    l=im@LW; m=l.mean(); dark=(l<.05).mean(); hot=(l>.88).mean()
    d1=l-blur(l,1); d2=blur(l,1)-blur(l,3); d3=blur(l,3)-blur(l,8); d4=blur(l,8)-blur(l,20)
    e=[float(np.sqrt((d*d).mean())) for d in (d1,d2,d3,d4)]
    # coherent edges vs noise: correlation of the fine band with its neighbour
    c=d1; co=float(((c[:,1:]*c[:,:-1]).mean()+(c[1:]*c[:-1]).mean())/(2*(c*c).mean()+1e-9))
    mx,mn=im.max(2),im.min(2); ch=(mx-mn); h=np.zeros_like(mx)
    R,G,B=im[...,0],im[...,1],im[...,2]; dd=np.where(ch<1e-6,1,ch)
    h=np.where(mx==R,((G-B)/dd)%6,np.where(mx==G,(B-R)/dd+2,(R-G)/dd+4))/6
    hist=np.histogram(h,18,(0,1),weights=ch)[0]; hist=hist/(hist.sum()+1e-9); ent=float(-(hist*np.log(hist+1e-9)).sum())
    border=float(np.concatenate([l[0],l[-1],l[:,0],l[:,-1]]).mean()/(m+1e-6))
    spread=float(np.mean([l[i*30:(i+1)*30,j*40:(j+1)*40].mean()>.05 for i in range(3) for j in range(4)]))
    s= 1.1*min(e[0],.10)/.10+1.3*min(e[1],.12)/.12+.9*min(e[2],.12)/.12+.5*min(e[3],.1)/.1
    s+= .55*min(ent,1.9)/1.9+.5*spread+ 1.2*min(0,co+.02)*1.0
    s-= 6*max(0,hot-.02)+1.5*max(0,dark-.72)+2.5*max(0,.12-dark)+.5*max(0,border-.9)
    return s,dict(m=round(float(m),3),dark=round(float(dark),2),hot=round(float(hot),3),e=[round(x,3) for x in e],co=round(co,2),ent=round(ent,2))
def evaluate(g,i,dirn):
    tmp=f'{D}/tmp/{os.getpid()}.png'; out=f'{D}/{dirn}/{i:05d}.png'
    if not frame(g,tmp): return None
    im=expose(g,tmp)
    if im is None: return None
    m=(im@LW).mean()
    if not .06<m<.42: return None
    s,st=score(im)
    if st['dark']>.9 or st['hot']>.12 : return None
    g['score']=s; g['stat']=st; g['id']=i
    return im
def run(dirn,seed,count,maker,seconds):
    import time; t0=time.time(); os.makedirs(f'{D}/{dirn}',exist_ok=True); os.makedirs(D+'/tmp',exist_ok=True)
    log=open(f'{D}/{dirn}/log.jsonl','a'); n=k=0
    for i in range(count):
        if time.time()-t0>seconds: break
        r=random.Random(f'{seed}/{i}'); g=maker(r,i); n+=1
        try: im=evaluate(g,i,dirn)
        except Exception as ex: print(i,ex); continue
        if im is None: continue
        k+=1
        Image.fromarray((im*255).round().astype('uint8')).save(f'{D}/{dirn}/{i:05d}.png')
        log.write(json.dumps(g)+'\n'); log.flush()
    open(f'{D}/{dirn}/count.txt','a').write(f'seed {seed}: drawn {n} alive {k} in {time.time()-t0:.0f} s\n')
if __name__=='__main__':
    run('g1',20261125,int(sys.argv[1]),lambda r,i:draw(r),float(sys.argv[2]))
