#include "net/url.hpp"

#include <gtest/gtest.h>

namespace mien::net {
namespace {

TEST(Url, ReadsHostPortAndName) {
    const auto expect = [](const char* text, const Url& url) {
        const auto parsed = parse_url(text);
        ASSERT_TRUE(parsed.ok()) << text << ": " << parsed.error().message;
        EXPECT_EQ(*parsed, url) << text;
    };
    expect("mien://example.org/take", {"example.org", kDefaultPort, "take"});
    expect("mien://127.0.0.1:99/a/b", {"127.0.0.1", 99, "a/b"});
    expect("mien://[::1]:8000/x", {"::1", 8000, "x"});
    expect("mien://[fe80::1]", {"fe80::1", kDefaultPort, ""});
    expect("mien://host:65535", {"host", 65535, ""});
    expect("mien://host/", {"host", kDefaultPort, ""});
    expect("mien://host/two%20words%2f%C3%A9", {"host", kDefaultPort, "two words/é"});
}

TEST(Url, NamesWhatIsWrong) {
    const auto complaint = [](const std::string& text) {
        const auto parsed = parse_url(text);
        return parsed ? std::string("accepted") : parsed.error().message;
    };
    EXPECT_NE(complaint("http://host/x").find("mien://"), std::string::npos);
    EXPECT_NE(complaint("mien:///x").find("host"), std::string::npos);
    EXPECT_NE(complaint("mien://host:0/x").find("port"), std::string::npos);
    EXPECT_NE(complaint("mien://host:65536/x").find("port"), std::string::npos);
    EXPECT_NE(complaint("mien://host:12a/x").find("port"), std::string::npos);
    EXPECT_NE(complaint("mien://host:/x").find("port"), std::string::npos);
    EXPECT_NE(complaint("mien://[::1/x").find("closed"), std::string::npos);
    EXPECT_NE(complaint("mien://[::1]x/x").find("port"), std::string::npos);
    EXPECT_NE(complaint("mien://host/%4").find("%"), std::string::npos);
    EXPECT_NE(complaint("mien://host/%zz").find("%"), std::string::npos);
    EXPECT_NE(complaint("mien://host/" + std::string(300, 'x')).find("too long"), std::string::npos);
}

TEST(Url, GoesThereAndBack) {
    for (const Url& url : {Url{"host", 1, "plain"}, Url{"::1", 7777, "mit Umlaut ä/ö%"}, Url{"10.0.0.1", 65535, ""}}) {
        const auto back = parse_url(to_string(url));
        ASSERT_TRUE(back.ok()) << to_string(url);
        EXPECT_EQ(*back, url) << to_string(url);
    }
}

TEST(Url, TellsAnAddressFromAFileName) {
    EXPECT_TRUE(looks_like_url("mien://host/x"));
    EXPECT_TRUE(looks_like_url("http://host/x"));
    EXPECT_FALSE(looks_like_url("takes/one.mien"));
    EXPECT_FALSE(looks_like_url("C:/takes/one.mien"));
}

}  // namespace
}  // namespace mien::net
