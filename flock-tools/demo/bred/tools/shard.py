import breed,sys
breed.run(sys.argv[1],int(sys.argv[2]),100000,lambda r,i:breed.draw(r),float(sys.argv[3]))
