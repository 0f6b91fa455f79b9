#include "evaluation/accuracy/published_data.h"

namespace treeline::accuracy {

const char* PublishedData() {
  // dataset: KIND | name | protocol
  // method: name | training | query | source | note
  // scene | per cent within 5 cm and 5 degrees | median cm | median degrees
  return R"data(
dataset: 7scenes | Microsoft 7-Scenes | The original poses (KinectFusion) and the official split: whole sequences for training, other ones for testing. Frames within 5 cm and 5 degrees, and medians.
method: Sparse features | RGB-D | RGB | thesis, Table 4.3
Chess | 70.7 | - | -
Fire | 49.9 | - | -
Heads | 67.6 | - | -
Office | 36.6 | - | -
Pumpkin | 21.3 | - | -
Red Kitchen | 29.8 | - | -
Stairs | 9.2 | - | -
average | 40.7 | - | -
method: PoseNet | RGB | RGB | thesis, Tables 4.4 and 5.3 | network on a GPU
Chess | - | 32 | 8.12
Fire | - | 47 | 14.4
Heads | - | 29 | 12
Office | - | 48 | 7.68
Pumpkin | - | 47 | 8.42
Red Kitchen | - | 59 | 8.64
Stairs | - | 47 | 13.8
average | - | 44 | 10.4
method: Bayesian PoseNet | RGB | RGB | thesis, Tables 4.4 and 5.3 | network on a GPU
Chess | - | 37 | 7.24
Fire | - | 43 | 13.7
Heads | - | 31 | 12
Office | - | 48 | 8.04
Pumpkin | - | 61 | 7.08
Red Kitchen | - | 58 | 7.54
Stairs | - | 48 | 13.1
average | - | 47 | 9.81
method: Active Search | SfM | RGB | thesis, Table 5.3
Chess | - | 4 | 1.96
Fire | - | 3 | 1.53
Heads | - | 2 | 1.45
Office | - | 9 | 3.61
Pumpkin | - | 8 | 3.1
Red Kitchen | - | 7 | 3.37
Stairs | - | 3 | 2.22
average | - | 5 | 2.46
method: Hybrid forest + SIFT | RGB-D | RGB | thesis, Table 3.1 (chapter 3)
Chess | - | 12 | 3.92
Fire | - | 14 | 4.64
Heads | - | 10 | 6.82
Office | - | 15 | 4.23
Pumpkin | - | 22 | 5.4
Red Kitchen | - | 14 | 3.71
Stairs | - | 30 | 8.08
average | - | 17 | 5.26
method: SCRF | RGB-D | RGB-D | thesis, Tables 5.2 and 5.3
Chess | 92.6 | 3 | 0.66
Fire | 82.9 | 5 | 1.5
Heads | 49.4 | 6 | 5.5
Office | 74.9 | 4 | 0.78
Pumpkin | 73.7 | 4 | 0.68
Red Kitchen | 71.8 | 4 | 0.76
Stairs | 27.8 | 32 | 1.32
average | 67.6 | 8 | 1.6
method: MultiOutput | RGB-D | RGB-D | thesis, Tables 4.3 and 5.2
Chess | 96 | - | -
Fire | 90 | - | -
Heads | 56 | - | -
Office | 92 | - | -
Pumpkin | 80 | - | -
Red Kitchen | 86 | - | -
Stairs | 55 | - | -
average | 79.3 | - | -
method: BRF | RGB-D | RGB-D | thesis, Tables 4.3 and 4.4
Chess | 97.8 | 1.7 | 0.69
Fire | 92.1 | 1.8 | 0.99
Heads | 77.3 | 2.8 | 2.66
Office | 91.3 | 2.2 | 0.9
Pumpkin | 76.5 | 2.4 | 0.9
Red Kitchen | 85.4 | 2.7 | 1.22
Stairs | 51.3 | 4.7 | 1.4
average | 81.7 | - | 1.25
method: BTBRF | RGB-D | RGB-D | thesis, Tables 4.3 and 4.4
Chess | 99.6 | 1.5 | 0.59
Fire | 95.2 | 1.6 | 0.89
Heads | 90.4 | 2 | 1.84
Office | 95.9 | 1.8 | 0.75
Pumpkin | 75.7 | 2.3 | 0.84
Red Kitchen | 89.4 | 2.5 | 1.02
Stairs | 60.8 | 4 | 1.22
average | 86.7 | 2.2 | 1.02
method: Uncertainty | RGB-D | RGB-D | thesis, Table 5.2
Chess | 99.4 | - | -
Fire | 94.6 | - | -
Heads | 95.9 | - | -
Office | 97 | - | -
Pumpkin | 85.1 | - | -
Red Kitchen | 89.3 | - | -
Stairs | 63.4 | - | -
average | 89.5 | - | -
method: AutoContext | RGB-D | RGB-D | thesis, Table 5.2
Chess | 99.6 | - | -
Fire | 94 | - | -
Heads | 89.3 | - | -
Office | 93.4 | - | -
Pumpkin | 77.6 | - | -
Red Kitchen | 91.1 | - | -
Stairs | 71.7 | - | -
average | 88.1 | - | -
method: PLForest | RGB-D | RGB-D | thesis, Tables 5.2 and 5.3
Chess | 99.5 | 1.4 | 0.57
Fire | 97.6 | 0.9 | 0.48
Heads | 95.5 | 0.8 | 0.68
Office | 96.2 | 1.7 | 0.73
Pumpkin | 81.4 | 1.9 | 0.65
Red Kitchen | 89.3 | 2.5 | 1.02
Stairs | 72.7 | 2.7 | 0.71
average | 90.3 | 1.7 | 0.7
method: Active Search | SfM | RGB | Sattler et al. 2017
average | 68.8 | - | -
method: hloc | SfM | RGB | Sarlin et al. 2019
average | 76.7 | - | -
method: DSAC* | RGB-D | RGB | Brachmann and Rother 2021 | trains for 15 h on a GPU; 28 MB
average | 82.9 | - | -
method: ACE | RGB | RGB | Brachmann et al. 2023 | trains for 5 min on a GPU; 4 MB
average | 81 | - | -
method: DSAC* | RGB-D | RGB-D | Brachmann and Rother 2021 | trains for 15 h on a GPU; 28 MB
average | 94.7 | - | -
method: Relocalisation cascade with ICP | RGB-D | RGB-D | Cavallari et al. 2019 | GPU; about 99 %
average | 99 | - | -
method: DSAC* | RGB-D | RGB-D | Brachmann and Rother 2021 | trains for 15 h on a GPU; 28 MB
Stairs | 92.6 | - | -
Pumpkin | 80.8 | - | -
dataset: 12scenes | Stanford 4-Scenes | The original poses (BundleFusion) and the official split. Frames within 5 cm and 5 degrees.
method: ORB+PnP | RGB-D | RGB | thesis, Table 4.2
apt1/kitchen | 66.39 | - | -
apt1/living | 41.99 | - | -
apt2/bed | 71.72 | - | -
apt2/kitchen | 63.91 | - | -
apt2/living | 45.4 | - | -
apt2/luke | 54.65 | - | -
office2/5a | 28.97 | - | -
office2/5b | 56.87 | - | -
office1/gates362 | 49.48 | - | -
office1/gates381 | 43.87 | - | -
office1/lounge | 61.16 | - | -
office1/manolis | 60.1 | - | -
average | 53.7 | - | -
method: SIFT+PnP | RGB-D | RGB | thesis, Table 4.2
apt1/kitchen | 71.43 | - | -
apt1/living | 56.19 | - | -
apt2/bed | 72.95 | - | -
apt2/kitchen | 71.74 | - | -
apt2/living | 56.19 | - | -
apt2/luke | 70.99 | - | -
office2/5a | 38.43 | - | -
office2/5b | 45.78 | - | -
office1/gates362 | 67.88 | - | -
office1/gates381 | 62.77 | - | -
office1/lounge | 58.72 | - | -
office1/manolis | 72.86 | - | -
average | 62.2 | - | -
method: Random+SIFT | RGB-D | RGB | thesis, Table 4.2
apt1/kitchen | 70.3 | - | -
apt1/living | 60 | - | -
apt2/bed | 65.7 | - | -
apt2/kitchen | 76.7 | - | -
apt2/living | 52.2 | - | -
apt2/luke | 46 | - | -
office2/5a | 49.5 | - | -
office2/5b | 56.4 | - | -
office1/gates362 | 67.7 | - | -
office1/gates381 | 54.6 | - | -
office1/lounge | 54 | - | -
office1/manolis | 65.1 | - | -
average | 59.9 | - | -
method: MNG | RGB-D | RGB + 3D model | thesis, Table 4.2
apt1/kitchen | 85.7 | - | -
apt1/living | 71.6 | - | -
apt2/bed | 66.4 | - | -
apt2/kitchen | 76.7 | - | -
apt2/living | 66.6 | - | -
apt2/luke | 83.3 | - | -
office2/5a | 66.2 | - | -
office2/5b | 71.1 | - | -
office1/gates362 | 51.8 | - | -
office1/gates381 | 52.3 | - | -
office1/lounge | 64.2 | - | -
office1/manolis | 76 | - | -
average | 69.3 | - | -
method: BTBRF, RGB | RGB-D | RGB | thesis, Table 4.2
apt1/kitchen | 77.1 | - | -
apt1/living | 69.6 | - | -
apt2/bed | 60.8 | - | -
apt2/kitchen | 82.9 | - | -
apt2/living | 62.5 | - | -
apt2/luke | 39.3 | - | -
office2/5a | 50.3 | - | -
office2/5b | 58.5 | - | -
office1/gates362 | 82.1 | - | -
office1/gates381 | 51.4 | - | -
office1/lounge | 59.6 | - | -
office1/manolis | 68.5 | - | -
average | 63.6 | - | -
method: UBRF | RGB-D | RGB-D | thesis, Table 4.2
apt1/kitchen | 82.6 | - | -
apt1/living | 81.7 | - | -
apt2/bed | 71.6 | - | -
apt2/kitchen | 80 | - | -
apt2/living | 65.3 | - | -
apt2/luke | 50.5 | - | -
office2/5a | 68 | - | -
office2/5b | 83.2 | - | -
office1/gates362 | 88.9 | - | -
office1/gates381 | 73.9 | - | -
office1/lounge | 74.6 | - | -
office1/manolis | 87.2 | - | -
average | 75.6 | - | -
method: BRF | RGB-D | RGB-D | thesis, Table 4.2
apt1/kitchen | 88.2 | - | -
apt1/living | 90.5 | - | -
apt2/bed | 81.3 | - | -
apt2/kitchen | 85.7 | - | -
apt2/living | 92.3 | - | -
apt2/luke | 71.5 | - | -
office2/5a | 85.7 | - | -
office2/5b | 92.3 | - | -
office1/gates362 | 90.4 | - | -
office1/gates381 | 82.3 | - | -
office1/lounge | 91.4 | - | -
office1/manolis | 93.9 | - | -
average | 87.1 | - | -
method: BTBRF | RGB-D | RGB-D | thesis, Table 4.2
apt1/kitchen | 92.7 | - | -
apt1/living | 95.1 | - | -
apt2/bed | 82.8 | - | -
apt2/kitchen | 86.2 | - | -
apt2/living | 99.7 | - | -
apt2/luke | 84.6 | - | -
office2/5a | 89.9 | - | -
office2/5b | 98.9 | - | -
office1/gates362 | 96.7 | - | -
office1/gates381 | 92.9 | - | -
office1/lounge | 94.8 | - | -
office1/manolis | 98 | - | -
average | 92.7 | - | -
method: PLForest | RGB-D | RGB-D | thesis, Table 5.1
apt1/kitchen | 98.9 | - | -
apt1/living | 100 | - | -
apt2/bed | 99 | - | -
apt2/kitchen | 99 | - | -
apt2/living | 100 | - | -
apt2/luke | 98.9 | - | -
office2/5a | 98.8 | - | -
office2/5b | 99 | - | -
office1/gates362 | 100 | - | -
office1/gates381 | 98.8 | - | -
office1/lounge | 99.1 | - | -
office1/manolis | 100 | - | -
average | 99.3 | - | -
method: hloc | SfM | RGB | Sarlin et al. 2019
average | 99.8 | - | -
dataset: tum | TUM RGB-D, dynamic sequences | Trained on fr3 sequences, tested on their validation sequences, in worlds aligned by Horn's method: sequences with people in motion, not ours. Frames within 5 cm and 5 degrees, and medians.
method: BTBRF | RGB-D | RGB-D | thesis, Table 4.5
sitting_static | 64.6 | 1.5 | 0.99
sitting_xyz | 70.2 | 2.9 | 0.72
sitting_halfsphere | 44.4 | 5.6 | 1.59
sitting_rpy | 74.6 | 2.9 | 0.98
walking_halfsphere | 61.7 | 4.2 | 1.03
walking_rpy | 53.7 | 4.7 | 1.14
walking_static | 89.2 | 1.9 | 0.49
walking_xyz | 41.7 | 4.8 | 1.24
average | 62.5 | 3.6 | 1.02
method: PLForest | RGB-D | RGB-D | thesis, Table 5.4
sitting_static | 72.2 | 1.2 | 0.93
sitting_xyz | 74.1 | 2.8 | 0.73
sitting_halfsphere | 39.8 | 6.1 | 1.76
sitting_rpy | 77.9 | 2.6 | 0.94
walking_halfsphere | 46.6 | 5.2 | 1.26
walking_rpy | 53.4 | 4.7 | 1.01
walking_static | 97.3 | 1.7 | 0.35
walking_xyz | 46.6 | 4.7 | 1.22
average | 63.5 | 3.6 | 1.02
dataset: cambridge | Cambridge Landmarks | Outdoors, 35 to 140 m wide, colour alone; poses by structure from motion, the official split. Medians.
method: Active Search, not prioritized | SfM | RGB | thesis, Table 4.6
King's College | - | 59 | 0.48
Old Hospital | - | 125 | 0.71
Shop Facade | - | 18 | 0.65
St Mary's Church | - | 26 | 0.5
average | - | 57 | 0.59
method: Active Search, prioritized | SfM | RGB | thesis, Table 4.6
King's College | - | 67 | 0.52
Old Hospital | - | 129 | 0.79
Shop Facade | - | 17 | 0.53
St Mary's Church | - | 29 | 0.55
average | - | 61 | 0.6
method: PoseNet | RGB | RGB | thesis, Table 4.6 | network on a GPU
King's College | - | 192 | 5.4
Old Hospital | - | 231 | 5.38
Shop Facade | - | 146 | 8.08
St Mary's Church | - | 265 | 8.48
average | - | 208 | 6.83
method: Bayesian PoseNet | RGB | RGB | thesis, Table 4.6 | network on a GPU
King's College | - | 174 | 4.06
Old Hospital | - | 257 | 5.14
Shop Facade | - | 125 | 7.54
St Mary's Church | - | 211 | 8.38
average | - | 192 | 6.28
method: CNN+LSTM | RGB | RGB | thesis, Table 4.6 | network on a GPU
King's College | - | 99 | 3.65
Old Hospital | - | 151 | 4.29
Shop Facade | - | 118 | 7.44
St Mary's Church | - | 152 | 6.68
average | - | 130 | 5.52
method: PoseNet, geometric loss | RGB | RGB | thesis, Table 4.6 | network on a GPU
King's College | - | 88 | 1.04
Old Hospital | - | 320 | 3.29
Shop Facade | - | 88 | 3.78
St Mary's Church | - | 157 | 3.32
average | - | 163 | 2.86
method: BTBRF on SIFT | SfM | RGB | thesis, Table 4.6 | one CPU core
King's College | - | 39 | 0.36
Old Hospital | - | 30 | 0.41
Shop Facade | - | 15 | 0.31
St Mary's Church | - | 20 | 0.4
average | - | 27 | 0.39
method: hloc | SfM | RGB | Sarlin et al. 2019 | 7 to 14 cm and 0.2 to 0.3 degrees, by scene
average | - | - | -
)data";
}

}  // namespace treeline::accuracy
