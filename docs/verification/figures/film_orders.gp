# Draw again: run gnuplot on this file, in its own folder.
if (!exists("PASS")) PASS = 1
reset
if (PASS == 1) set terminal pdfcairo size 16cm,12cm font "DejaVu Sans,7" fontscale 0.75 linewidth 1; set output "film_orders.pdf"
if (PASS == 2) set terminal pngcairo size 1600,1200 font "DejaVu Sans,7" fontscale 2.64583 linewidth 2; set output "film_orders.png"
DATA = "film_orders.dat"
ORIGIN = "freeplay 0.1.0 (fcce175b1f), verification"
CAPTION = ""
set encoding utf8
WIDTH = 16; HEIGHT = 12  # cm
SIZE = 7  # pt
X(cm) = cm*SIZE/7.0/WIDTH; Y(cm) = cm*SIZE/7.0/HEIGHT
SMALL = sprintf(',%g', 0.88*SIZE); TINY = sprintf(',%g', 0.8*SIZE)
MONO = 0
C1 = 0x0b3c8c
C2 = 0xc8500a
C3 = 0x000000
C4 = 0x1b7837
C5 = 0x7b3294
C6 = 0x8c510a
C7 = 0x01665e
C8 = 0xb2182b
C9 = 0x3d9be0
set style line 1 lc rgb C1 lw 1.6 dt 1 pt 6 ps 1.1
set style line 2 lc rgb C2 lw 1.3 dt (12,5) pt 2 ps 1.0
set style line 3 lc rgb C3 lw 2.2 dt (2,4)
set style line 4 lc rgb 0x888888 lw 1.0 dt 1
set border lw 0.8
set tics nomirror scale 0.6
set grid lt 1 lc rgb 0xd4d4d4 lw 0.7
set key outside top center horizontal samplen 3 spacing 1.1
set pointsize 1
set bmargin at screen Y(1.15)
set logscale xy
set format '10^{%T}'
set xlabel "step (s)"
set ylabel "error over eccentricity or clearance"
set key outside top center horizontal
plot DATA index 0 using 1:2 with linespoints lw 1.4 dt 1 pt 4 lc rgb '#0b3c8c' title "short full film", DATA index 1 using 1:2 with linespoints lw 1.4 dt 2 pt 5 lc rgb '#c8500a' title "long full film", DATA index 2 using 1:2 with linespoints lw 1.4 dt 3 pt 6 lc rgb '#000000' title "lubricated pin of a slider-crank"
unset output
PASS = PASS + 1
if (PASS <= 2) load "film_orders.gp"
