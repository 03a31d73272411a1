import json,numpy as np
from PIL import Image
from breed import blur,LW
FAV="""h2:247 h1:418 h3:274 h1:233 h1:201 h2:560 h3:532 h2:411 h2:248 h2:531 h1:322 h2:228 h1:399 h3:168 h1:69 h3:394 h2:549 h2:278 h1:181 h3:507 h2:496 g6:110 h3:485 h3:81 h1:456 g6:192 h2:200 h1:249 h2:194 h3:257 g5:286 h3:11 h2:198 h1:103 h1:375 h3:44 h1:515 h2:46 h2:155 g3:14 g2:36 g3:34 g4:24 g4:20 g3:5 g2:8 g1:31 g1:12 g3:21 g4:36 g2:13 g6:24 g6:32 g2:47 g6:30 g2:52 g2:48 g5:49 g2:105 g6:53 g6:50 g2:79 g4:75 g4:98 g5:54 g6:6 g4:69 g4:116 g3:76 g2:84 g6:44 g3:60 g4:83 g2:87 g4:39 g1:20 g1:1 g4:8 g3:1 g3:30 g4:9 g4:1 g4:19 g1:3 g2:38 g6:1 g3:84 g4:53
h1:328 h3:376 h1:189 h2:223 h3:282 h2:87 h2:261 h3:384 h2:388 h3:286 h3:293 h1:226 h3:202 h1:163 h3:325 h1:222 h3:110 h1:134 h3:215 h1:101 h3:374 h3:265 h1:144 h1:239 h2:287 h2:166 h1:385 h2:95 h3:205""".split()
def feats(im):
    l=im@LW; m=l.mean(); f=[m,(l<.03).mean(),(l<.08).mean(),(l>.5).mean(),(l>.8).mean()]
    bs=[l]+[blur(l,k) for k in (1,3,8,20)]
    for i in range(4):
        d=bs[i]-bs[i+1]; s=float(np.sqrt((d*d).mean())); f+=[s/(m+.05),float((d**4).mean()/(s**4+1e-9))**.25]
    for b,k in ((bs[1],2),(bs[1],5),(bs[2],6)):
        gx=np.gradient(b,axis=1);gy=np.gradient(b,axis=0);A,B,C=blur(gx*gx,k),blur(gy*gy,k),blur(gx*gy,k)
        f.append(float(np.sqrt((A-B)**2+4*C*C).sum()/((A+B).sum()+1e-9)))
    mx,mn=im.max(2),im.min(2);ch=mx-mn;R,G,Bb=im[...,0],im[...,1],im[...,2];dd=np.where(ch<1e-6,1,ch)
    h=np.where(mx==R,((G-Bb)/dd)%6,np.where(mx==G,(Bb-R)/dd+2,(R-G)/dd+4))/6
    hist=np.histogram(h,18,(0,1),weights=ch)[0];hist=hist/(hist.sum()+1e-9)
    f+=[float(-(hist*np.log(hist+1e-9)).sum()),float((ch*l).sum()/(l.sum()+1e-9))]
    H,W=l.shape; cells=np.array([[l[i*H//3:(i+1)*H//3,j*W//4:(j+1)*W//4].mean() for j in range(4)] for i in range(3)])
    f+=[float(cells.std()/(m+.02)),float((cells<.02).mean()),float(cells[1,1:3].mean()/(m+.02)),float(np.abs(l-l[:,::-1]).mean()/(m+.02))]
    d=bs[0]-bs[1]; f.append(float(((d[:,1:]*d[:,:-1]).mean()+(d[1:]*d[:-1]).mean())/(2*(d*d).mean()+1e-9)))
    return np.array(f)
def load_im(d,i): return np.asarray(Image.open(f'/root/breed/{d}/{i:05d}.png').convert('RGB')).astype(float)/255
if __name__=='__main__':
    seen=set(open('seen.txt').read().split()); X={}
    import os
    for d in 'g1 g2 g3 g4 g5 g6 h1 h2 h3 k1 k2 k3'.split():
        for line in open(f'{d}/log.jsonl'):
            try: g=json.loads(line)
            except Exception: continue
            if d=='g5' and g['id']<40: continue
            X[f"{d}:{g['id']}"]=feats(load_im(d,g['id']))
    ids=list(X); M=np.array([X[i] for i in ids]); mu,sd=M.mean(0),M.std(0)+1e-9; Z=np.clip((M-mu)/sd,-3,3); Z=np.hstack([Z,Z*Z*.5,np.ones((len(Z),1))])
    tr=[k for k,i in enumerate(ids) if i in seen]; y=np.array([ids[k] in FAV for k in tr],float); T=Z[tr]; w=np.zeros(T.shape[1]); wt=np.where(y>0,len(y)/y.sum()/2,1)
    for it in range(3000):
        p=1/(1+np.exp(-T@w)); w-=.05*((T*((p-y)*wt)[:,None]).mean(0)+.01*w)
    s=Z@w; json.dump({i:float(v) for i,v in zip(ids,s)},open('fit.json','w'))
    a=s[[k for k in tr if ids[k] in FAV]]; b=s[[k for k in tr if ids[k] not in FAV]]; print(len(ids),len(tr),y.sum(),'auc',(a[:,None]>b[None]).mean())
    un=sorted((k for k in range(len(ids)) if ids[k] not in seen),key=lambda k:-s[k]); print(len(un)); open('rank.txt','w').write('\n'.join(ids[k] for k in un))
