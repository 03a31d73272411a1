import numpy as np
from breed import blur,LW
def rescore(im):
    l=im@LW; m=l.mean(); dark=(l<.05).mean(); hot=(l>.8).mean()
    b1=blur(l,1);b3=blur(l,3);b8=blur(l,8)
    e=[float(np.sqrt((d*d).mean()))/(m+.08) for d in (b1-b3,b3-b8,b8-blur(l,20))]
    # line-likeness: structure tensor coherence of mid band, weighted by gradient
    gx=np.gradient(b1,axis=1); gy=np.gradient(b1,axis=0); A,B,C=blur(gx*gx,2),blur(gy*gy,2),blur(gx*gy,2)
    tr=A+B; coh=np.sqrt((A-B)**2+4*C*C); line=float(coh.sum()/(tr.sum()+1e-9))
    mx,mn=im.max(2),im.min(2); ch=mx-mn; R,G,Bb=im[...,0],im[...,1],im[...,2]; dd=np.where(ch<1e-6,1,ch)
    h=np.where(mx==R,((G-Bb)/dd)%6,np.where(mx==G,(Bb-R)/dd+2,(R-G)/dd+4))/6
    hist=np.histogram(h,18,(0,1),weights=ch)[0]; hist=hist/(hist.sum()+1e-9); ent=float(-(hist*np.log(hist+1e-9)).sum())
    sat=float((ch*l).sum()/(l.sum()+1e-9))
    s=2.2*(min(line,.75)-.35)/.4+.8*min(e[0]/.25,1)+.6*min(e[1]/.35,1)+.3*min(e[2]/.4,1)+.5*min(ent,1.8)/1.8+.6*min(sat,.5)/.5
    s-=12*max(0,hot-.03)+3*max(0,dark-.6)+1.5*max(0,.1-dark)
    return s
