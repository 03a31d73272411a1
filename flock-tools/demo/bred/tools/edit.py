import sys,json; from big import load
# edit.py new src dx dy zoom bfac [palname shift ripple flip hue]
n,s=sys.argv[1:3]; dx,dy,z,b=map(float,sys.argv[3:7]); g=load(s); c=g['cam']
g['cam']=[c[0]+dx*c[2],c[1]+dy*c[2],c[2]/z]; g['b']*=b; g['b']=round(g['b'],4)
if len(sys.argv)>7: g['pal']=[sys.argv[7],float(sys.argv[8]),float(sys.argv[9]),sys.argv[10]=='1',float(sys.argv[11])]
g['src']=g.get('src',s); json.dump(g,open(f'/root/breed/fin/{n}.json','w'))
