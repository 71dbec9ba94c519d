package org.mrsfi.interop;

import com.google.gson.Gson;
import com.google.gson.GsonBuilder;
import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import com.google.gson.JsonParser;
import java.io.InputStreamReader;
import java.io.OutputStreamWriter;
import java.io.PrintStream;
import java.io.Reader;
import java.io.Writer;
import java.nio.charset.StandardCharsets;

/** Carries out one command: JSON request on standard input, JSON answer on standard output. */
public final class Main {

    private static final Gson GSON =
            new GsonBuilder().serializeNulls().disableHtmlEscaping().create();

    private Main() {}

    /**
     * Runs the command that the first argument names.
     *
     * @param arguments resave, evl, eol, egl or configured
     * @throws Exception if the request cannot be carried out at all
     */
    public static void main(String[] arguments) throws Exception {
        JsonObject request;
        try (Reader reader = new InputStreamReader(System.in, StandardCharsets.UTF_8)) {
            request = JsonParser.parseReader(reader).getAsJsonObject();
        }
        PrintStream answers = System.out;
        // What libraries print must not stand in the middle of the answer.
        System.setOut(System.err);
        JsonElement answer = GSON.toJsonTree(run(arguments[0], request));
        try (Writer writer = new OutputStreamWriter(answers, StandardCharsets.UTF_8)) {
            GSON.toJson(answer, writer);
        }
    }

    private static Object run(String command, JsonObject request) throws Exception {
        return switch (command) {
            case "resave" -> Saving.resave(request);
            case "evl" -> Validation.validate(request);
            case "eol" -> Programs.query(request);
            case "configured" -> Configuration.run(request);
            case "egl" -> Programs.generate(request);
            default -> throw new IllegalArgumentException(
                    "command is '" + command + "'; expected resave, evl, eol, egl or configured");
        };
    }
}
