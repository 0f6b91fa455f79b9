#include "server/tools/capture/record3d.h"

#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/lzfse.h"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/capture/zip_archive.h"

namespace treeline::capture {
namespace {

using testing::HasSubstr;

// What Apple's own encoder (lzfse -encode) made of the 12000 bytes of Golden().
constexpr const char* kGoldenStream =
    "YnZ4MuAuAACAFhAPAVcEMAJA8IEMBgdwvgAAABH4cACXa445mhpVExX4Aa52ZhRFYauarI"
    "uboyfgGXgDvoB34PpsCgAAAAAAAAAAAADcHV7end2dHZ6f3l0eXl5ent2dXt6d3l0eXt4d"
    "3h2eXd6d3l3e3V6eXh7e3R1enl2enR3eHV6enR7eXd2dHR6eAgAAAAAAAAAAAAAAAAAAAA"
    "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACHYgWj3qPPB+8TWlzxg9W9q"
    "A2DUIQePxpgR9QkWAMuXwP2hr+BYcXJYBS25kDBx+3F1xj1kJ1fQrNEo1mxA1D1PoX8Jr1"
    "iC9V8rrfIm+EvQDldgPm60lGjguLwANSoN9wirXhSsDlGpgRrjjbUPofWXnySILiutVe4N"
    "bJRbuTywYC4y8k6C1KhuIXGVYqLyam6aswAUyb1BBx3x4scMsCJ9uR385+RYlFcM3y0Ah/"
    "S/ifVU06OSLmKQfxUBe9YiuAjcbkiw3SYR1BXDixnFT0XgwaOmlCOKXH+tRsjVudL5v8qw"
    "IfB9gC2K2f/V3RAIP+exmcOm3xYE1d5c+TQrDzZjAZgGRsBzeqFygFi/gxN7TMDh4tpydV"
    "Yjx4kchDAB4VjEsTxgxXFYuF2fQlst8RoOOfeASPrXx944/3ZOPRceZoRZ2GaIy5JaLoUb"
    "q+o+wmwICCzUb93Mc2eCiy3BfrARTA87M1mwcJ/EI0r935K54aXFo8+AEePbAFHBwb47c1"
    "J3o4IDZQ0SLV0+FbdWlMqJ6MSbE4cx7t7LXkMXv1IlrU8Vb37S3Eub1/bgxBNQb0D+19uc"
    "hc8u4iUEcrVnwt3Z4Oy9sdBUzgW8mM5bsI3ceBN9qghWiRk06im7Y17EKQ726mfijtZGiu"
    "hnLr3eqmLMtrGBmtoVenx6Xj4ql2EJDrIVwMoQL/b6z9R0VwZeuW+ZVXxaKbvU/CaENzfI"
    "dlsvEWDsaIIva/ZCzQrcRa2Tf07PH1qX4fMwlDYh93eAuVVF5FB2fC05sNBC84Te8LweTc"
    "nqY5Ri30+X7S4txuhFJs2RA/7+40BJv4jEOLLq7V3oM0t9WjAiLORiNxOCTuTTosD7vdZ7"
    "QpG4a+xak4cIh/q2sy/WAXKsaxL6MqQrbKEpY9P6TCi+2DHvRYloO+Ak7TJtX7Eiqg+Ip5"
    "1ACefB1SskO3nHlLvCZQ+sZE+WWUtcld798hZVA6CtvlKGY7sRMeIFzOWgARIeDhtXr9nh"
    "2Awk5kwol9C8IIGGFahzfpVHl/PgHbUgPkIhXb0T+VdAoioWoK2KATSf1MH95/DsxzcBvM"
    "Xa213ZgA2WOYtV1PLl8Vs+uJNTexo9qZB/DerTvTRkDQdj2lixe3o/e8XIruaY9StJ9lW1"
    "+4V2Slpx+FrEoLGqXmBjozPDEEGaaC+JHz1ZdJpuyX2HhRg08usF3G+G2R1Bn7ZFfJ4Xgg"
    "9l9iAqTU1zylYTHKQdtgMiSEEVD8BU92HSOBFonkQz7DI6bzFq36SmEzBxaJ2co496MBiA"
    "ZzQ9qalIM39IT9P7dabqbBRF13QWYHeJFVQ82GKqUpMFl+k6/hcgdiO5MDKCRTnVbV1/JC"
    "LCbBm2DjkMELuSXLKLykgi8k6lsdPFD7k/Egj6obtyoaL8RgaNTvVXkj60tx1zkmtPeORp"
    "fO8P0DS0oeseVTUJHL1TLmqLe6FY6t7aMetKit0I5adlYMrZM2rlypsuAgbNjS5+2gr6G2"
    "HQ0PmFCkTsfihePIqFNB2FwB2irGyklvBjnQlYeSNb/bZapxD5M3dznt3BfLaftB8FmF3U"
    "Mbi8qAVeyIVcpFh6hRGO0cf5HnHooBCBz+/JHcCVmgr+qzuxuePsCpnY0Zp9JidJz5bbvf"
    "PQQ87XyTC9Faha4VXHNxug/Y8PKgEU0T7KbuDn1nAPzm4RrjV22gnZVAedP3llZ0ftZhsu"
    "QPxOzZ+D2/PI79cCne/Lb7WFMUlLGMI46KoNQFj239vr3rfLBZ1Yb77VNjET/W/NC7yiZc"
    "CHpYy8YMmSuAe3WqrUSFEFNRvzXd5lCUs4IRMCsAALf/DHn45wZaYZ74ETZI/2vd+7/vUf"
    "0iFBpTwR03TbAtuiJNdFCgrUAq9yWd/5BcBgJ8ic9/+rBJLk5rK54h/dtfq5RBu1MR9sXL"
    "tD3fzzCZbqGa9d8YTzp/Q2mecbJClKH1e5BzcWB20OecMgkp0aZe3fsFlBFInJrq0xwHzL"
    "FgcweDnzM2+tpvELMnYhnf2vHn+4trdG7K+xl05v1AW9VY36W+o4SiMA9VL8v2G/elmeN3"
    "03SIAVjNBVov6r0Rpn8nvByrhT7d2SaNUhPdYyBcCfrjJZJ2/6MRpFtZeUlvyC7UCLgOio"
    "IuXeTefWFPbK6fNzowq8hkGkiN5dZuIBWEw+CkDl3KIlbwF9kafXvV7Dd/xpuOCsERG6KA"
    "Byl3QPoMWAe7EdRLjY27yO5QBulDOCIIsUlKtreOvABW+T2V6wILslRMHXTgQnel/VantI"
    "q+qU+ixDDmnanhfn+JcFElb/+kBWudl8P7ige7gUR+6juCZKqLZQVXiFYNiqKp3edyAkpe"
    "lIELZXcYZ1/H4Hj8Fc2WohygjC1Cr6hJ6wZftgWL3f92Nslo9Mh+c/pNFJ1t/5WPG9fUQD"
    "Yb9mKC0W3dczZKFsJz/2TKeiqf1gzcHV9cWW2pVNLj6WvIOqj4gw/eNgMVFlkzENj7AU8K"
    "J2+4ud7Uw5ovWHNTRUwmzAE5xSuOBDA2hlHVME5R+8mDa1nvg37bAyAYtzQTcElMh6kZd3"
    "+QqpzAtPZ0Q2/gm39g/QbLR5FXSlD1/WFP9VJ/JGw7XWelNBPx/qyD/uInq9QGzMbKrmvO"
    "a0CToDeqbzImtc6OTPg8oz402rdpc9I3hSyTvFxhgge+xfgVfrb2eSeVO42S3+jBWAlvRs"
    "p+C4VuyxdOnumR/BLB1ecXpFI8OnR9FRl1WcRZhW6TCA3aYB5NBDq47Y8t8nipAibppkBl"
    "UJRGLCse/FcdlO9A9FJz8TObn2Cb0PuKyJtq8iuVvIc0IHt2gEWbQU/hmvkG2Z5R3bZcRI"
    "y1SNHNv+M5bonmYPbU6kc8NarI7lw2RRx3YByKtl6rqRHwD4O8Q3nm8wVz4eEC3y6SuICz"
    "1zL1Eiawc9J5o8ngtbb4CrCTgRSrzYTq0RywUQTsYTbtahNT9GsxFLXiKfvnfibGZEfgIS"
    "jhflwlr3qN1r5WIBPDckLWDbiDLiSmhXHap3ZKbeQDYpcwvgT8rCQyz2cAtHMvdMoZd5yo"
    "bZt0pstfkgs34qIJPSa7RhckOF00gb3dlPJjK1dwYLxVs/YqpUqEbt2SC0fvwNO2lGQS+F"
    "q/B2Uqwcxma4m+F+C/ddLqSDnxW6zJTtxVtAwS3xnEXqimqFr5JjU9d0VxCpqELNgGJSUw"
    "RlVUl3OmcWqqnfj+j3EH2aetgB7ExQvzF1OhWLK5QEL66BDvR/S6NR+hTMt495LEOKipID"
    "2GsQb8dVJrG31TtA+FPVNLdxykDFcJjpKa6nULmRlUdJxpPE4boOY2Zfrf+i/KgVFg3gJf"
    "AtieghOyyd9/f1FBiYDiJMDOt9oXztKjDXNaPv9UhatgfSBl37Wvmm89cJlBYapN3s9XfG"
    "OJ0nDkQeie5xxSuLaDp/B70Zlbf6hjrdK3YnDh2iL63EddHpYcbNGOfQ3MuLXEBTIG3u5b"
    "nqf5j8gQIErDO4fMj5iH6sWfXSWHxYgoqg+7hCUsC5iFuX8yV8FNDBn94F66GOYNhwF3Fz"
    "EuuBO2Hqtb/0JQCXgwpsBAM3WwQ36N+DQmZEePSpcod6w78VHCn9ReNNGO5NQe1om3NA0j"
    "+pGFM5fb2QVdyPc7wLEDPz7OBO5UeUABv1xvjJh65Q+0b0Y5Up+7szYjdH1DJlENpI4dHz"
    "bNjLJ9FtUYbMmk3iot9VCY/erEyG/fv8k7MlGF7TIbNoGmUwcW5+9cyx+4WqRckBer1fqj"
    "s6RdDoZ9PtllW5wWlikD+gsyXMfqB2PSA/arwlSJqZdZwb73fQaQL980MiLVCl3EqT7cqB"
    "uE3t27UBiY1uvN8x5FhG8AENwY1uuQeNmv2SFpai6izvGMos7/8LKK4yiLWUDY6DYlsDUv"
    "UKhQfvyuhHGqm3Whv4XOMjNHUQAYoIO/oj2uDzFfD3SHpyLmEh9WSbNH3U0h+60LvErlx2"
    "U0ZZvLUXEfZcZfxDPGFPDP9KEhvrACO0NcUiXYRmRnNyFZeJNf95iMx6qRvesauHM+ZQHy"
    "zpUSvYg7BCTvLqF5BFXXKv6/aAtVV3kM74sFytQ3ykcmrwgYrY8HRGL2e/fgBwIbkouiuA"
    "Fxeac/qoQMIHTvoUugtFawXwc4b4WFyI1UH6zB1+DZ2fxQTcvZJfLTK2qFHwtAP+a7pyDt"
    "7T1iH0eoyCQv+vFJdZUG0PvKleSIRXfH7Km3vyYY2H2fHvhVst3TtdRA39syu4uUcZ/D6v"
    "8c3zVVTMQguJ2s/nsoLlGgH81Odfnn+jYtpiHQlu8KvIC3KWJiXPFopbgtuXCPz7j0+M70"
    "DVyGXhqgZ/j0yKBf4PQmyKV7UBg64QgyfGXrITiqyqB4ixQUArFe8+xzVxpH8f32+t2znY"
    "TXil4oRzZmdwqBdbWRp08Kf6jAb3ShtEWrpU6m5lo7KENrR3UpL1q2SqFQY4qbHB6hb591"
    "UvLvbPfDx/ICxgwsynp1KjvtYGFTR7iY+wz14H3UU/F/UMyPSPbl7l8y6ugxovgy7tEfXy"
    "fxgxghr1lf9m00EZPGVP/1RgcpijnapdiaCtuf0KrHoz/WNQkKNMbNpu8w8Ts9svVBKsiD"
    "39ddacJJBaPGwM7qKvzAw6ewfKq4JjDG8eQabwFjJwVuVPpylb9m8hZNDx5xVjaDNr6KLN"
    "EhxGq4na3TPacTVHGkmwux2W7P5Jgp6+YZKcTKe5/YjpccrJOOgB9tP13HMlyS/DDLQIwo"
    "+a2/rW8/8AmLSLKmwjScT/9T2TE6ZZWbqNse26AsP0PLK8/zzwe7Q4XDiCrckrREDFttOk"
    "/XmucL6YoT3TmhvE9BVOY3GnamuFJpq5/zebRdq6AoqrnpFLu4PaXyzZJS4vPNVVaALSVW"
    "33pRyizZwrHF+Mc9/L7ZgDsDYVCIjmhRNKAatDXr4wgYjFqWu+lVTX8/Y+2hCfIWo+G6IA"
    "mtKaV2Ry8iAgqYsla6hSA6H/g3y1e+4fOJ+traDJtXwWizMQAS8/EXGsjjYrKTlakTFxKj"
    "WhNnq4g7fKhA91nXar13bSULUd/Glo3e+JNpPaEzrInx1x6zuG/f4QWqt7HEayyeyfRHP8"
    "OmIqkR1yphGuNrSZYUM3/Z4Sj1Lk9lakYTUCdltcS+k954bY59Cho5Nv6mmItAShXSWpYj"
    "ZZdfKDuEt2W5xRi07PIcTvipqeKXmTh3ZJODuvsPsXzjuMwE/ValoShL4jJ6/9GUYxKlbT"
    "69vyHLeFuoAQfznHaJqGGDXJqnCe5nkYBWourwO/jcOoSQynaLkSwe8noZraep8QxHWehb"
    "A7iS6nKIoYIi7WKN1Hj7Nh6VjtAzE1NLXfgkAvNDQnYDvrg8R9cr871yTWl7iQtDG9PMDe"
    "iIXeA6ZcIrLESqC8For0goGH11krJhXOfpGPVTCtA6L8H003F9pID0dGHvL4ZstpbGQCE1"
    "2Ufxjz2WmsupHoAZwt50SZ25WdLuFkSPEW2oQWvrUWLnC+z/HctBMmCb67bQCxhhVtcZ2T"
    "CYmz0Sp4Kc2Q2+TaO9VC+IR0V7H48+PHZPCk3ulqJ8XQDmv7yZwVXSUiJdltmOMPiM9NRw"
    "YdLS0cQMj/OTKTAphfEXjO7j0+1+zuxliInUbEDIYOsqmifjMsHWRXQqhkVQUxBz077HVN"
    "o5tmttymWRVzmlGSsCAECfL/UMDzvc5uMBabVWX6fzMEo+FQJl8SyaCqJEkZxn2b5gQAML"
    "xtz8Pz75tlTaPr78txjtP377ttDMPoette17UsOI6XJIlhy7Lc922WJUVRRVHM82yWZQkh"
    "hAiCICzLst/3fY8AAAAAAAAAAAAAAPh0GXUEDM6N+od0v4iYE4MkN0D/TWT8SXszIdO/zz"
    "wtXQag4snIt2ztJ6/OzoVbfLWeCWoX+Kfu6QjsKfdFZpSZQisis5p1eTpixM/bs41wTINs"
    "SvyyLsoViYcmuWnrgkxcAw73yClWfheIdvpH+n/Wg4Y+p3woVZAAcFR028fvpbCt9iKmLB"
    "7zF3LcoyMR1yPWO/zSFQi0vIDqYnDpee7wEYoA7Y3IKs72nIcNCQSq5IjyO8Z/3CtUQV8j"
    "9IBP/qXmO+sfehiIQlIGRGkeCd3UB6o1o3GFa/XLpNpegJtQHGN7O2h0l+4MkcUIMOtWD+"
    "3Wu33cUHk8RItHGjle0wmd0p/0yEcg6nKDElFeLVb6hbiH4u55Fn/OPmPmmfgGTJv9SQqD"
    "MuFsxaBzIYVv8r4WeDu64rksdQ9il4hPUXfIR/mBsge+QLZWOZeQtRZH0in1gJNF5da4F4"
    "Gs8qrPnEL9dLftSCX2cAH8RvcIsd1AWqa9oVot7gM5zw9Jv0zVVJboFHEgCui51GPcSrSu"
    "R/QHZBaLy1nJE791ugZs0AEwuWAjqv8eeWuGkYuiSxzIDfWFJRe4nqpU/rEwdoLV7hbVbt"
    "w4Qqih5xau8grhIFVTZMu9psB4X8ctpySPFDrM3BjirwIbAdBjJQ0eMLIgyC+qIQp0nZZ9"
    "92k3ihwdj5DKtLbRwQdNq8RcHtXnHQLbNFjwSRgB0KBQ7cXNYyXPCoc2kXC+6q3zniPOr0"
    "9fcd8xgL6YmEa+9Cg1djOH+QqxgLvQeb29U80IvXhNW3cACjvjYk3er24gZfPG6f73DlY9"
    "hNiBmObop7vq7OK9ovWeYeloHjkFBwNWWb9PYRNUcQB7UmBCd7fY+4HwZF9WtocjVwtcys"
    "SnZfI6Kz9OMxXNzXZax9/O9bCXpzpPchvoup2vZnNK2NhgSdJJCJfGo4NmDzksODrf48oo"
    "fW2TaJZ9JYo8RAtWnvdDs9K6biTh2YAT12dmW2c+vBKthcaad/7XjFGA3yc3yzQ18SCtPW"
    "+cQWjgpyyt8g5MCBLrz7DCh92qdgUEPuaihKPxfCaGrDQxkzf3a0xMTTBP8jeUn9oCSbQ2"
    "af5jr4htt9HkBP0w0/MwEwGjUHgfAY1aEgX/rX2dXB2DORYx3tyQmZtYO2y4hOKX25WA8m"
    "qxfg/COY1EZYOLm3Kr0KHbufoKOgzeWrt8zP/o4cQ6827IVKqZRBqEd5OQsqgF+yzBiP3r"
    "rnO1SQbKCqcTtLhQmZpyOhkUW0/hvBNkx0fBdZ/DtaWT3cXdAuEZ0XTrAgtEN4d/cqUCzA"
    "PKxbv8gQHGScrYtrZYkzchFLDQWYypO1rUx06rLXju4X5RDk58RlNxA5seku+rwIoGfykn"
    "JW4MIKBEKvtiG0IU1LtxYXkzLGHIrmQf0gL4vyzUlRbqHCCgmRMoxFyHGco6XYY5NewgKf"
    "05lmNYWVZFzcnSh1r35O8PPBnEW8vqj85I4HVkE9WOAi9num3goV+NUSH1xA8a1+ex1e5c"
    "ZEESvNC/SEUgDnF6hSf0w7FXbF0w7dq63nm9WDM8Hnu19ZP+tzYryHFEZ6CBIy7GNhcBQL"
    "S9ad50yGaOv4WzJHxagGeYMxNT3GPsMzpC+/zCyhMM15LPWZBQSjvK5wq8owxNFEXOq/cB"
    "YSh7Lq4tvgYiT4Kw5YFOVo6RLdG1IhB6vA6RKXdHPEO6Iyq/A0tCNOOuHlV1f6rXJES58H"
    "eLjxf2wKR53evTVE4b7/XoArNKpl8y5kO3t2NTK7427m3gDzyMPpu55RLpz+9C1DgmHXxL"
    "KxuzBY+cBKGCfluDL7mp80sEr+8M7qyIKMw9yBZwlAcI0wC/dA0CLT2CGT+nDUi2vIce/o"
    "rUuLgxW62RgqYx9fMJyrCYjJHWMJfyhph1K84XA6ULBlhPU8ob7bjt4avmpEQ1zOGRCAc3"
    "B0R5UYztUUUDz704puxT1ULEzuNV+xiMFDiU2KTiJNxdavwQJwGyL1MoEeXVYtv7GCF2sY"
    "JqBAHHuF+myaWjWD+HXI6kLoBzr5D8ppGOAfR+yuLOUbUvwHAkqEZG7RPDI6alcwdo9Rj4"
    "RnnFFwFA0eSjMQWGqCEqLXsu1jgv6Oah+b+EAiKV+36/rJuCQDXghimqwr6dicvZl46S48"
    "URo/KE4vkrXCMVpyhUEdkthyAL7nM7QQg0PzRR6I6VeLIX+9SHfBBQPzkF/e5gSV1sdvSn"
    "W72BvYBafpCMII54/giHTJLqbpgZZkTuZjQWAKGDT1dtCkaovnNkvDUON3RyWxzcTy9uA/"
    "y9lXwEMdPCFP4gGXHLgt8Zej6EegpIj3WcCZ41kKO/N65llj7Atx+OrnMounh+A2v8THxJ"
    "ALWUxmouWxUKfdoKy3RZrAcmEEFEiAjwHGJ2eCQ=";

std::vector<uint8_t> Golden() {
  std::vector<uint8_t> bytes;
  for (uint32_t i = 0; i < 12000; ++i) {
    bytes.push_back(static_cast<uint8_t>((i * i) >> 9 & 0x3f));
  }
  return bytes;
}

std::string GoldenStream() {
  std::string stream;
  EXPECT_TRUE(absl::Base64Unescape(kGoldenStream, &stream));
  return stream;
}

TEST(LzfseTest, ReadsWhatApplesEncoderWrote) {
  const auto decoded = DecodeLzfse(GoldenStream(), 12000);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, Golden());
}

TEST(LzfseTest, DamagedStreamsAndOtherLengthsAreRefused) {
  const std::string stream = GoldenStream();
  EXPECT_FALSE(DecodeLzfse(stream, 11999).ok());
  EXPECT_FALSE(DecodeLzfse(stream, 12001).ok());
  EXPECT_FALSE(DecodeLzfse("", 0).ok());
  EXPECT_FALSE(DecodeLzfse("bvxn0000", 8).ok());
  for (size_t length = 0; length < stream.size(); ++length) {
    EXPECT_FALSE(DecodeLzfse(stream.substr(0, length), 12000).ok()) << length;
  }
}

TEST(Record3dTest, DepthIsInMillimetresAndNanIsNone) {
  std::string stream = "bvx-";
  const auto append = [&stream](uint32_t value) {
    for (int i = 0; i < 4; ++i) {
      stream.push_back(static_cast<char>(value >> (8 * i)));
    }
  };
  append(16);
  for (const float depth_m : {1.2345f, std::nanf(""), -1.0f, 70.0f}) {
    append(std::bit_cast<uint32_t>(depth_m));
  }
  const auto depth = DecodeRecord3dDepth(stream + "bvx$", {4, 1});
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->values, (std::vector<uint16_t>{1235, 0, 0, 0}));
}

TEST(Record3dTest, OwnIntrinsicsOfAFrameWinAndBadPosesAreLeftOut) {
  const auto metadata = ParseRecord3dMetadata(
      R"({"w":720,"h":960,"K":[600,0,0,0,601,0,360,480,1],)"
      R"("poses":[[0,0,0,1,1,2,3],[0,0,0,0,0,0,0],[0,0,0,1,0,0,null]],)"
      R"("perFrameIntrinsicCoeffs":[[610,611,361,481]]})",
      "metadata");
  ASSERT_TRUE(metadata.ok()) << metadata.status();
  ASSERT_EQ(metadata->frames.size(), 1u);
  EXPECT_EQ(metadata->frames[0].camera.ToString(),
            "PINHOLE,610,611,360.5,480.5");
  EXPECT_EQ(metadata->left_out.count(), 2);
  EXPECT_FALSE(metadata->depth_size.has_value());
}

TEST(Record3dTest, AVideoWithoutPosesSaysWhy) {
  EXPECT_THAT(
      ParseRecord3dMetadata(
          R"({"w":720,"h":960,"K":[1,0,0,0,1,0,0,0,1],"poses":[]})", "m")
          .status()
          .message(),
      HasSubstr("LiDAR"));
}

class ZipTest : public testing::Test {
 protected:
  absl::StatusOr<ZipArchive> Open(const std::string& bytes) const {
    return ZipArchive::OpenFile(folder_.Write("a.zip", bytes));
  }
  const base::TestingFolder folder_;
};

TEST_F(ZipTest, EntriesByName) {
  const auto archive =
      Open(ZipOf({{"a", "alpha"}, {"../../b", std::string(9999, 'x')}}));
  ASSERT_TRUE(archive.ok()) << archive.status();
  EXPECT_EQ(archive->Read("a").value(), "alpha");
  EXPECT_EQ(archive->Read("../../b").value(), std::string(9999, 'x'));
  EXPECT_EQ(archive->Read("c").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(ZipTest, BombsAndDamageAreRefused) {
  const std::string bomb = ZipOf({{"a", std::string(1 << 20, 'x')}});
  // The size that the directory says, after 24 bytes of it: more and less.
  const size_t size_at = bomb.find("PK\x01\x02") + 24;
  for (const uint32_t size : {0xf0000000u, 100u, (1u << 20) + 1}) {
    std::string changed = bomb;
    for (size_t i = 0; i < 4; ++i) {
      changed[size_at + i] = static_cast<char>(size >> (8 * i));
    }
    const auto archive = Open(changed);
    ASSERT_TRUE(archive.ok()) << archive.status();
    EXPECT_EQ(archive->Read("a").status().code(),
              absl::StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(Open("PK").ok());
  EXPECT_FALSE(Open(bomb.substr(0, bomb.size() - 5)).ok());
  EXPECT_THAT(Open(ZipOf({{"a", "1"}, {"a", "2"}})).status().message(),
              HasSubstr("twice"));
  std::string flipped = ZipOf({{"a", "alpha"}});
  flipped[flipped.find("PK\x01\x02") + 16] ^= 1;
  EXPECT_THAT(Open(flipped)->Read("a").status().message(),
              HasSubstr("checksum"));
}

}  // namespace
}  // namespace treeline::capture
