# loop8.py out WxH spp id... : 8 angles each as 4x2
import sys; from big import load; import breed
from PIL import Image,ImageDraw
out,size,spp=sys.argv[1:4]; w,h=map(int,size.split('x')); ids=sys.argv[4:]
im=Image.new('RGB',(4*w,len(ids)*2*h)); dr=ImageDraw.Draw(im)
for k,id in enumerate(ids):
    ms=[]
    for a in range(8):
        p=breed.render(load(id),'/root/breed/tmp/l8.png',(w,h),spp,('--frame',str(a),'--frames','8','--temporal-samples','1'))
        l=p@breed.LW; ms.append('%.2f/%.3f'%(l.mean(),(l>.9).mean())); im.paste(Image.open('/root/breed/tmp/l8.png').convert('RGB'),(a%4*w,(2*k+a//4)*h)); dr.text((a%4*w+3,(2*k+a//4)*h+2),f'{id} {a} {ms[-1]}',fill=(255,255,255))
    print(id,*ms)
im.save(out)
